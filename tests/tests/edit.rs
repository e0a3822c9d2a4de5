//! Edited mesh colors as files: they are valid, and what a conversion makes of them has no seams.

use std::path::Path;
use std::process::Command;

use meshcolor::asset::Asset;
use meshcolor::edit::{self, Edited, ResolutionChange, Scheme, Selection};
use meshcolor::measure::{SubjectKind, Verdict};
use meshcolor::pipeline::{Conversion, MipFilter, Options, check, convert};
use meshcolor::read::{Limits, Upload, read};
use meshcolor::watch::Unwatched;
use meshcolor::{ErrorCode, Result};
use meshcolor_tests::cases::{self, Case};
use meshcolor_tests::{models, validator};
use serde_json::Value;

/// Quads, polygons, cuts, materials over several meshes, normals, alpha, whatever cannot be subdivided, and edges of three
/// faces.
const CASES: [&str; 12] = [
    "alpha_blend",
    "material_over_two_meshes",
    "materials_two_in_a_mesh",
    "moebius_strip",
    "normal_with_tangent",
    "obj_polygon",
    "obj_quad_and_triangle",
    "obj_two_objects",
    "primitives_weld",
    "seam_painted_hard",
    "skin_morph_animation",
    "three_faces_disagree",
];

/// The bundle's promise.
const SEAM_MAX_CODES: f64 = 1.5;

fn glb(bytes: &[u8]) -> Upload {
    Upload::single("mesh_colors.glb", bytes.to_vec())
}

fn asset(bytes: &[u8]) -> Asset {
    read(&glb(bytes), &Limits::default(), &Unwatched).unwrap()
}

fn converted(upload: &Upload) -> Conversion {
    let options = Options { mesh_colors: true, ..Options::default() };
    convert(upload, &options, &Limits::default(), &Unwatched).unwrap()
}

fn mesh_colors(conversion: &Conversion) -> &[u8] {
    &conversion.files.iter().find(|file| file.path == "mesh_colors.glb").unwrap().bytes
}

fn resolution(asset: &Asset, by: i8) -> Result<Edited> {
    let change = ResolutionChange { by, filter: MipFilter::Area };
    edit::resolution(asset, &Selection::default(), change, &Limits::default(), &Unwatched)
}

fn subdivided(asset: &Asset, scheme: Scheme) -> Result<Edited> {
    edit::subdivide(asset, scheme, &Limits::default(), &Unwatched)
}

fn without_a_face(asset: &Asset) -> Result<Edited> {
    let painted = asset.materials.iter().position(|material| material.mesh_colors.is_some());
    let first = Selection { material: painted, faces: Some(vec![[0, 0]]) };
    edit::delete(asset, &first, &Limits::default(), &Unwatched)
}

/// Valid, read again, and without seams once converted.
fn expect_sound(name: &str, edited: &Edited) {
    validator::expect_valid(name, &edited.glb, false);
    let report = check(&glb(&edited.glb), &Options::default(), &Limits::default(), &Unwatched).unwrap();
    assert_eq!(report.kind, SubjectKind::MeshColors, "{name}");
    let conversion = converted(&glb(&edited.glb));
    assert_ne!(conversion.report.verdict, Verdict::Fail, "{name}: {:?}", conversion.report.errors);
    assert!(conversion.report.max_seam_delta_codes <= SEAM_MAX_CODES, "{name}");
    validator::expect_valid(name, &conversion.files[0].bytes, false);
}

#[test]
fn every_operation_leaves_files_that_are_sound() {
    let mut done = 0;
    for case in CASES {
        let folder = cases::folder().join(case);
        let conversion = converted(&Case::load(&folder).upload(&folder));
        let painted = asset(mesh_colors(&conversion));
        let edits = [
            ("finer", resolution(&painted, 1)),
            ("coarser", resolution(&painted, -1)),
            ("midpoint", subdivided(&painted, Scheme::Midpoint)),
            ("catmull-clark", subdivided(&painted, Scheme::CatmullClark)),
            ("deleted", without_a_face(&painted)),
        ];
        for (operation, edited) in edits {
            match edited {
                Ok(edited) => expect_sound(&format!("{case}, {operation}"), &edited),
                // Skins, morph targets, and meshes of one face; the text says what to do.
                Err(error) => {
                    assert_eq!(error.code, ErrorCode::InvalidOptions, "{case}, {operation}: {error}");
                    continue;
                }
            }
            done += 1;
        }
    }
    assert!(done >= 50, "{done} of 60 edits were done");
}

#[test]
fn what_was_edited_is_edited_again() {
    let folder = cases::folder().join("obj_quad_and_triangle");
    let before = converted(&Case::load(&folder).upload(&folder));
    let finer = resolution(&asset(mesh_colors(&before)), 1).unwrap();
    let back = resolution(&asset(&finer.glb), 1).unwrap();
    let counts = |edited: &Edited| {
        let edit = &edited.report.materials[0];
        (edit.sample_count_before, edit.sample_count)
    };
    assert_eq!(counts(&finer).1, counts(&back).0);
    assert!(counts(&back).1 > 3 * counts(&back).0);
}

/// `pirate.glb` has no texture, and no coordinates for one: it gets its colors from a figure of another shape.
#[test]
fn the_pirate_is_painted_and_converted() {
    let Some(spot) = models::upload("spot") else { return };
    let Some(pirate) = models::bytes("pirate.glb") else { return };
    let source = asset(mesh_colors(&converted(&spot)));
    let target = read(&Upload::single("pirate.glb", pirate), &Limits::default(), &Unwatched).unwrap();
    let edited = edit::transfer(&source, None, &target, 0, &Limits::default(), &Unwatched).unwrap();
    let report = edited.report.transfer.clone().unwrap();
    println!("the pirate, {} faces: {report:#?}", edited.report.materials[0].face_count);
    // Of 5010 triangles all but 34 have a partner.
    assert_eq!(edited.report.materials[0].face_count, 2522);
    assert!(report.distance_max.is_finite() && report.distance_rms > 0.0);
    expect_sound("pirate", &edited);
}

fn run(arguments: &[&str], folder: &Path) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_meshcolor_as_built"));
    let output = command.args(arguments).current_dir(folder).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn the_command_edits_files() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let case = cases::folder().join("obj_quad_and_triangle");
    let conversion = converted(&Case::load(&case).upload(&case));
    std::fs::write(folder.join("in.glb"), mesh_colors(&conversion)).unwrap();

    let (code, out, error) = run(&["edit", "resolution", "in.glb", "--by", "1", "-o", "finer.glb"], folder);
    assert_eq!((code, out.as_str()), (Some(0), ""), "{error}");
    assert!(error.contains("finer.glb: material 0: 2 faces (before 2)"), "{error}");
    let (code, _, error) = run(&["edit", "resolution", "in.glb", "--by", "-1", "-o", "finer.glb"], folder);
    assert!(code == Some(2) && error.contains("--force"), "{error}");
    let (code, out, error) =
        run(&["edit", "subdivide", "finer.glb", "--format", "json", "-o", "four.glb"], folder);
    assert_eq!(code, Some(0), "{error}");
    let report: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(report["materials"][0]["face_count"], 8);
    let (code, _, error) = run(&["edit", "delete", "four.glb", "--faces", "0,2-3", "-o", "hole.glb"], folder);
    assert!(code == Some(0) && error.contains("5 faces (before 8)"), "{error}");
    let (code, _, error) =
        run(&["edit", "transfer", "four.glb", "--to", "hole.glb", "-o", "new.glb"], folder);
    assert!(code == Some(0) && error.contains("baseColorTexture, in codes"), "{error}");
    let (code, _, error) = run(&["edit", "delete", "four.glb", "--faces", "9", "-o", "x.glb"], folder);
    assert!(code == Some(2) && error.contains("numbered 0 to 7"), "{error}");
    let (code, _, error) = run(&["edit", "subdivide", "four.glb", "-o", "x.obj"], folder);
    assert!(code == Some(2) && error.contains("x.obj does not end in .glb"), "{error}");
    let (code, out, error) = run(&["edit", "subdivide", "four.glb", "-o", "-", "--quiet"], folder);
    assert!(code == Some(0) && out.starts_with("glTF") && !folder.join("-").exists(), "{error}");
    let (code, _, error) = run(&["edit", "subdivide", "four.glb", "-o", "-", "--format", "json"], folder);
    assert!(code == Some(2) && error.contains("name a file"), "{error}");
    let (code, out, error) = run(&["check", "four.glb", "--quiet"], folder);
    assert_eq!((code, out.as_str(), error.as_str()), (Some(0), "", ""));
}
