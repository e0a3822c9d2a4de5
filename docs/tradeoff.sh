#!/usr/bin/env bash
# Makes the records of docs/tradeoff anew, and with them every picture, table and README line that comes
# from them. Run it on a machine that does nothing else: it takes times.
#
#   docs/tradeoff.sh               all models and the scaling bench
#   docs/tradeoff.sh MODEL...      only these: sample, spot_control_mesh, DamagedHelmet, Fox, spot_fine, scaling
#
# Of Fox and spot_fine only the curve of texels against error is shown, in docs/storage.md.
#
# REPEAT is how often each rung converts (3 without it); models are looked for in MESHCOLOR_ASSETS.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

assets=${MESHCOLOR_ASSETS:-../shared/assets}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
models=("$@")
[ ${#models[@]} -gt 0 ] || models=(sample spot_control_mesh DamagedHelmet Fox spot_fine scaling)

for model in "${models[@]}"; do
  case $model in
    sample) input=() ;;
    spot_control_mesh | spot_fine) input=("$assets/spot/$model.obj") ;;
    DamagedHelmet | Fox) input=("$assets/$model.glb") ;;
    scaling)
      MESHCOLOR_WRITE_DOCS=1 cargo bench -p meshcolor --bench scaling -- --rungs-most 100000
      continue
      ;;
    *)
      echo "unknown: $model" >&2
      exit 2
      ;;
  esac
  cargo run --release -p meshcolor -- tradeoff "${input[@]}" -o "$scratch/$model" --repeat "${REPEAT:-3}"
  cp "$scratch/$model/tradeoff.json" "docs/tradeoff/$model.json"
done

# Pictures and tables from the records.
for test in pictures_and_tables the_readme_shows curves_are; do
  MESHCOLOR_WRITE_DOCS=1 cargo test --release -p meshcolor-tests --test tradeoff "$test"
done
