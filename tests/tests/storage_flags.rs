//! `--merge`, `--max-size` and `--no-share` by the command line: what they make of a model, and that nobody sees a difference.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use glam::{Vec2, Vec3};
use meshcolor::asset::Asset;
use meshcolor::finished::{Finished, extract};
use meshcolor::image::Image;
use meshcolor::read::{Limits, Upload, read};
use meshcolor::watch::Unwatched;
use meshcolor_tests::patches::{OBJ, Patch, Random, files, noise, smooth};
use meshcolor_tests::reading::{jumps_codes, shown_codes_of};
use meshcolor_tests::solids::{Kind, Mapping, random_box};
use serde_json::Value;
use tempfile::TempDir;

/// Texels are copied, so what is left is the rounding of a place.
const COPIED_CODES: f32 = 0.05;
/// What is promised of 8 bits.
const SEAM_CODES: f32 = 1.5;
/// With them what may differ in codes: 4D ones have texels beyond vertex colors that depend on where a face stands.
const COORDINATES: [(&str, f32); 2] = [("indexed", COPIED_CODES), ("4d", 1.0)];
/// Places along a side at which a face is looked at.
const PLACES: usize = 5;

/// A folder of a test's own, gone with it.
struct Folder(TempDir);

impl Folder {
    /// With a model in it.
    fn with(parts: &[(&Patch, &Image)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, bytes) in files(parts) {
            std::fs::write(folder.path(&name), bytes).unwrap();
        }
        folder
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }

    /// The model converted with more arguments, into a folder of a name.
    fn convert(&self, name: &str, more: &[&str]) -> Output {
        let (model, out) = (self.path(OBJ), self.path(name));
        run(&[&["convert", &model, "-o", &out, "--no-preview", "--quiet"], more].concat())
    }

    /// The same where it has to succeed, and what `check` finds in the file has to be fine.
    fn converted(&self, name: &str, more: &[&str]) -> Converted {
        let ended = self.convert(name, more);
        assert_eq!(ended.status.code(), Some(0), "{more:?}: {}", said(&ended));
        let path = format!("{}/asset.glb", self.path(name));
        let checked = run(&["check", "--quiet", "--format", "json", &path]);
        assert_eq!(checked.status.code(), Some(0), "{more:?}: {}", said(&checked));
        let checked: Value = serde_json::from_slice(&checked.stdout).unwrap();
        let upload = Upload::single("asset.glb", std::fs::read(path).unwrap());
        let asset = read(&upload, &Limits::default(), &Unwatched).unwrap();
        let finished = extract(&asset).unwrap().unwrap();
        Converted { asset, finished, checked: checked["files"][0]["report"].clone() }
    }
}

fn run(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_meshcolor_as_built"));
    // Settings of whoever runs the tests are not part of them.
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("MESHCOLOR_"))
    {
        command.env_remove(name);
    }
    command.args(arguments).stdin(Stdio::null()).output().unwrap()
}

fn said(ended: &Output) -> String {
    String::from_utf8_lossy(&ended.stderr).into_owned()
}

/// A converted file, by itself alone.
struct Converted {
    asset: Asset,
    finished: Finished,
    /// The report of `check`.
    checked: Value,
}

/// A triangle by the positions of its corners in order, as bits.
type Key = [[u32; 3]; 3];

impl Converted {
    /// Entries of a list of the glTF document.
    fn count(&self, list: &str) -> usize {
        self.asset.document.json[list].as_array().map_or(0, Vec::len)
    }

    fn primitive_count(&self) -> usize {
        self.asset.meshes.iter().map(|mesh| mesh.primitives.len()).sum()
    }

    /// Texels of level 0.
    fn texels(&self) -> u64 {
        let images = self.finished.textures.iter().map(|texture| &texture.levels[0]);
        images.map(|image| u64::from(image.width) * u64::from(image.height)).sum()
    }

    fn largest_side(&self) -> u32 {
        let images = self.finished.textures.iter().flat_map(|texture| &texture.levels);
        images.map(|image| image.width.max(image.height)).max().unwrap()
    }

    /// The corners of a triangle, each with its position, ordered by these.
    fn corners(&self, piece: usize, triangle: usize) -> [([u32; 3], usize); 3] {
        let piece = &self.finished.primitives[piece];
        let positions = &self.asset.meshes[piece.mesh].primitives[piece.primitive].positions;
        let vertices = piece.triangles[triangle].vertices;
        let at = |k: usize| (positions[vertices[k] as usize] + 0.0).to_array().map(f32::to_bits);
        let mut corners = [0, 1, 2].map(|k| (at(k), k));
        corners.sort_unstable();
        corners
    }

    /// Whether two triangles of an edge show textures of two parts.
    fn has_edge_between_parts(&self) -> bool {
        let mut parts: BTreeMap<[[u32; 3]; 2], BTreeSet<usize>> = BTreeMap::new();
        for (number, piece) in self.finished.primitives.iter().enumerate() {
            for triangle in 0..piece.triangles.len() {
                let [a, b, c] = self.corners(number, triangle).map(|(position, _)| position);
                for edge in [[a, b], [b, c], [a, c]] {
                    parts.entry(edge).or_default().insert(piece.part);
                }
            }
        }
        parts.values().any(|parts| parts.len() > 1)
    }

    /// What every triangle shows, by level of its texture.
    fn shown(&self) -> BTreeMap<Key, Vec<Vec<Vec3>>> {
        let mut all = BTreeMap::new();
        for (number, piece) in self.finished.primitives.iter().enumerate() {
            let (_, texture) = self.finished.textures_of(piece.material, piece.part).next().unwrap();
            for triangle in 0..piece.triangles.len() {
                let corners = self.corners(number, triangle);
                let color = |level: usize, shares: [usize; 3]| {
                    let mut at = Vec3::ZERO;
                    let share = |count: usize| count as f32 / PLACES as f32;
                    corners.iter().zip(shares).for_each(|((_, k), count)| at[*k] = share(count));
                    shown_codes_of(texture, level, piece.place_at(triangle, at, level))
                };
                let places =
                    || (0..=PLACES).flat_map(|i| (0..=PLACES - i).map(move |j| [i, j, PLACES - i - j]));
                let levels = 0..texture.levels.len();
                let colors = levels.map(|level| places().map(|place| color(level, place)).collect());
                let double = all.insert(corners.map(|(position, _)| position), colors.collect());
                assert!(double.is_none(), "two triangles at one place");
            }
        }
        all
    }

    /// Holds what two files show against each other, triangle by triangle, at the levels of the other.
    fn expect_shows_as(&self, other: &Self, most_codes: f32) {
        let [own, theirs] = [self.shown(), other.shown()];
        assert!(own.keys().eq(theirs.keys()), "other triangles");
        let mut colors = BTreeSet::new();
        for (own, theirs) in own.values().zip(theirs.values()) {
            assert!(own.len() >= theirs.len(), "{} levels, not {}", own.len(), theirs.len());
            for (own, theirs) in own.iter().flatten().zip(theirs.iter().flatten()) {
                assert!((*own - *theirs).abs().max_element() <= most_codes, "{own} is not {theirs}");
                colors.insert(own.as_ivec3().to_array());
            }
        }
        assert!(colors.len() > 20, "{} colors are no picture", colors.len());
    }
}

/// A sheet of quads at a height, whose texture coordinates go on from face to face.
fn sheet(side: [usize; 2], height: f32) -> Patch {
    let row = side[0] + 1;
    let at = |x: usize, y: usize| ((y * row + x) as u32, Vec2::new(x as f32, y as f32) * 0.23 + 0.1);
    let positions = (0..row * (side[1] + 1)).map(|k| Vec3::new((k % row) as f32, (k / row) as f32, height));
    let cells = (0..side[1]).flat_map(|y| (0..side[0]).map(move |x| (x, y)));
    let faces = cells.map(|(x, y)| vec![at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]);
    Patch { positions: positions.collect(), faces: faces.collect() }
}

#[test]
fn merged_materials_are_one_and_show_the_same() {
    let [below, above] = [sheet([3, 2], 0.0), sheet([2, 3], 1.0)];
    let pictures = [noise(&mut Random::new(1), 24, 24), smooth(40)];
    let folder = Folder::with(&[(&below, &pictures[0]), (&above, &pictures[1])]);
    for (coordinates, most_codes) in COORDINATES {
        let kind = ["--coordinates", coordinates, "--force"];
        let apart = folder.converted("apart", &kind);
        let merged = folder.converted("merged", &[&kind[..], &["--merge"]].concat());
        let counts = |of: &Converted| {
            [of.count("materials"), of.primitive_count(), of.count("textures"), of.finished.textures.len()]
        };
        assert_eq!(counts(&apart), [2; 4], "{coordinates}");
        assert_eq!(counts(&merged), [1; 4], "{coordinates}");
        // Both have the levels that one of them needs; what the other shows at those behind its own is its last.
        merged.expect_shows_as(&apart, most_codes);
    }
}

#[test]
fn what_is_larger_than_a_texture_is_split_without_a_seam() {
    let folder = Folder::with(&[(&sheet([5, 4], 0.0), &smooth(32))]);
    for (coordinates, most_codes) in COORDINATES {
        let fine = ["--resolution", "fixed:9", "--coordinates", coordinates, "--force"];
        let split = folder.converted("split", &[&fine[..], &["--max-size", "2048"]].concat());
        assert!(split.largest_side() <= 2048, "{}", split.largest_side());
        assert!(split.texels() > 2048 * 2048, "{} texels fit into one texture", split.texels());
        let parts: BTreeSet<usize> = split.finished.primitives.iter().map(|piece| piece.part).collect();
        assert!(parts.len() > 1 && split.finished.textures.len() == parts.len());
        assert_eq!([split.count("materials"), split.primitive_count()], [parts.len(); 2]);
        assert!(split.has_edge_between_parts());
        for texture in 0..split.finished.textures.len() {
            let jumps = jumps_codes(&split.asset, &split.finished, texture);
            assert!(jumps.iter().all(|jump| *jump <= SEAM_CODES), "{coordinates}: {jumps:?}");
        }
        assert_eq!(split.checked["verdict"], "pass", "{coordinates}");

        let whole = folder.converted("whole", &fine);
        assert_eq!([whole.count("materials"), whole.primitive_count()], [1; 2]);
        split.expect_shows_as(&whole, most_codes);
    }
}

#[test]
fn sizes_that_are_not_allowed_are_refused_in_words() {
    let folder = Folder::with(&[(&sheet([2, 1], 0.0), &smooth(32))]);
    for side in ["2047", "16385", "0", "many"] {
        let ended = folder.convert("out", &["--max-size", side]);
        assert_eq!(ended.status.code(), Some(2), "{side}");
        let said = said(&ended);
        assert!(said.contains("max-size") && said.contains("2048..=16384"), "{said}");
    }
    // 2049 texels a side, which no splitting makes less. 4D coordinates find that out before anything is painted.
    let fine = ["--resolution", "fixed:11", "--max-size", "2048", "--coordinates", "4d"];
    let ended = folder.convert("out", &fine);
    assert_eq!(ended.status.code(), Some(3));
    let said = said(&ended);
    assert!(
        said.contains("one face alone needs") && said.contains("more than the 2048 of max-size"),
        "{said}"
    );
    assert!(!Path::new(&folder.path("out")).exists());
}

#[test]
fn faces_that_do_not_share_take_more_texels_and_show_the_same() {
    for (mapping, least_times) in [(Mapping::Overlapping, 4), (Mapping::Mirrored, 2)] {
        let mut random = Random::new(7);
        let stamped = random_box(&mut random, 4, true, Kind::Parallelograms, mapping);
        let folder = Folder::with(&[(&stamped, &noise(&mut random, 24, 24))]);
        let shared = folder.converted("shared", &[]);
        let apart = folder.converted("apart", &["--no-share"]);
        let [few, many] = [&shared, &apart].map(Converted::texels);
        assert!(few * least_times < many, "{mapping:?}: {few} and {many} texels");
        apart.expect_shows_as(&shared, COPIED_CODES);
    }
}
