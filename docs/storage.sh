#!/usr/bin/env bash
# Takes the figures of docs/storage.md anew: the tables of docs/storage.py, the layout beside xatlas, the dense mesh. CPU
# seconds alone are times here, so other work on the machine does little harm. xatlas and numpy come from PyPI into a folder
# that is thrown away. The curves are drawn from the records of docs/tradeoff, which docs/tradeoff.sh makes.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

assets=${MESHCOLOR_ASSETS:-../shared/assets}
built=${CARGO_TARGET_DIR:-target}/release
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

cargo build --release -p meshcolor
cargo build --release -p meshcolor-core --example layout_time
python3 -m venv "$scratch/python"
"$scratch/python/bin/pip" install --quiet xatlas==0.0.11 numpy
docs/storage.py "$built/meshcolor" "$assets" "$built/examples/layout_time" "$scratch/python/bin/python"
MESHCOLOR_ASSETS=$assets MESHCOLOR_WRITE_DOCS=1 cargo test --release -p meshcolor-tests --test storage
