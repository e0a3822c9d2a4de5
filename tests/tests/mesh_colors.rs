//! `MCT_mesh_colors`: converting what `--mesh-colors` wrote gives the `asset.glb` that the source gave.

use std::path::Path;
use std::process::Command;

use meshcolor::measure::{ChannelReport, SubjectKind};
use meshcolor::pipeline::{Conversion, Coordinates, Options, check, convert};
use meshcolor::read::{Limits, Upload};
use meshcolor::watch::Unwatched;
use meshcolor::{Error, ErrorCode};
use meshcolor_tests::cases::{self, Case};
use meshcolor_tests::reading::shown_codes_of;
use meshcolor_tests::{hard, models, validator};
use serde_json::{Value, json};

/// What their source has wrong stays: a material that reads a set of coordinates which a primitive lacks.
const FAULTY: [&str; 1] = ["texcoord_missing"];

fn file<'c>(conversion: &'c Conversion, path: &str) -> &'c [u8] {
    let file = conversion.files.iter().find(|file| file.path == path);
    &file.unwrap_or_else(|| panic!("there is no {path}")).bytes
}

fn converted(upload: &Upload, options: &Options, limits: &Limits) -> Result<Conversion, Error> {
    convert(upload, options, limits, &Unwatched)
}

/// A case converted with its mesh colors.
fn painted(case: &str) -> Conversion {
    let folder = cases::folder().join(case);
    let options = Options { mesh_colors: true, ..Options::default() };
    converted(&Case::load(&folder).upload(&folder), &options, &Limits::default()).unwrap()
}

/// There and back: what went wrong. `None` where the source is refused.
fn trip(name: &str, upload: &Upload, options: &Options, limits: &Limits) -> Option<Result<(), String>> {
    let options = Options { mesh_colors: true, ..options.clone() };
    let there = converted(upload, &options, limits).ok()?;
    let glb = file(&there, "mesh_colors.glb");
    if !FAULTY.contains(&name) {
        validator::expect_valid(name, glb, false);
    }
    // How many samples there are stands in the file.
    let options = Options { texels: None, max_error: None, ..options };
    let back = match converted(&Upload::single("mesh_colors.glb", glb.to_vec()), &options, limits) {
        Ok(back) => back,
        Err(error) => return Some(Err(format!("{name}, its mesh colors: {error}"))),
    };
    if file(&back, "asset.glb") != file(&there, "asset.glb") {
        return Some(Err(format!("{name}: another asset.glb")));
    }
    assert_eq!(back.report.max_seam_delta_codes, there.report.max_seam_delta_codes, "{name}");
    if let Some(wrong) = judged(&there, &back) {
        return Some(Err(format!("{name}: {wrong}")));
    }
    Some(Ok(()))
}

/// What reports lack of errors against samples that they have against textures. Beyond the first level both are held
/// against nearly the same.
fn judged(there: &Conversion, back: &Conversion) -> Option<String> {
    for (textured, painted) in there.report.channels.iter().zip(&back.report.channels) {
        if textured.slots != painted.slots || textured.fidelity.is_some() != painted.fidelity.is_some() {
            return Some(format!("{:?} has {:?}", painted.slots, painted.fidelity));
        }
        if painted.fidelity.is_some_and(|fidelity| fidelity.yardstick_psnr_db.is_some()) {
            return Some("a yardstick without an image".to_owned());
        }
        let judged = |channel: &ChannelReport| -> Vec<bool> {
            channel.levels.iter().map(|level| level.mip_error.is_some()).collect()
        };
        if judged(textured) != judged(painted) {
            return Some(format!("{:?}: mip errors at other levels", painted.slots));
        }
    }
    None
}

fn all_go_round(folder: &Path) {
    let (mut count, mut wrong) = (0, Vec::new());
    let names = cases::names_in(folder);
    for name in &names {
        let folder = folder.join(name);
        let case = Case::load(&folder);
        let options = Options::from_json(&case.options).unwrap();
        let Some(trip) = trip(name, &case.upload(&folder), &options, &case.limits()) else { continue };
        count += 1;
        wrong.extend(trip.err());
    }
    assert_eq!(wrong, Vec::<String>::new());
    assert!(2 * count > names.len(), "only {count} of {} were converted", names.len());
}

#[test]
fn the_cases_go_round() {
    all_go_round(&cases::folder());
}

#[test]
fn the_hard_cases_go_round() {
    all_go_round(&hard::folder());
}

#[test]
fn real_models_go_round() {
    for name in ["Fox", "spot", "DamagedHelmet"] {
        let Some(upload) = models::upload(name) else { continue };
        assert_eq!(trip(name, &upload, &Options::default(), &Limits::default()), Some(Ok(())));
    }
}

/// Their level 0 is nearer to the samples than to the picture that these came from.
#[test]
fn real_models_are_near_their_samples() {
    for name in ["Fox", "spot", "DamagedHelmet"] {
        let Some(upload) = models::upload(name) else { continue };
        let options = Options { mesh_colors: true, ..Options::default() };
        let there = converted(&upload, &options, &Limits::default()).unwrap();
        let glb = file(&there, "mesh_colors.glb").to_vec();
        let back =
            converted(&Upload::single("mesh_colors.glb", glb), &Options::default(), &Limits::default())
                .unwrap();
        for (textured, painted) in there.report.channels.iter().zip(&back.report.channels) {
            let [from_picture, from_samples] = [textured, painted].map(|channel| channel.fidelity.unwrap());
            println!(
                "{name}, {}: PSNR {:.1} dB, from the picture {:.1} dB",
                painted.slots.join(" "),
                from_samples.psnr_db,
                from_picture.psnr_db
            );
            assert!(from_samples.psnr_db > from_picture.psnr_db + 3.0, "{name}: {from_samples:?}");
            let mip = |channel: &ChannelReport, level: usize| channel.levels[level].mip_error.unwrap().rms;
            for level in 3..painted.levels.len() {
                let [a, b] = [mip(textured, level), mip(painted, level)];
                assert!((a - b).abs() < 0.1 * a + 0.1, "{name}, level {level}: {a} {b}");
            }
        }
    }
}

#[test]
fn with_4d_coordinates_too() {
    for name in ["Fox", "spot"] {
        let Some(upload) = models::upload(name) else { continue };
        let options = Options { coordinates: Coordinates::Scaled, ..Options::default() };
        assert_eq!(trip(name, &upload, &options, &Limits::default()), Some(Ok(())));
    }
}

/// Mesh colors have their resolution, so options that ask for another are refused and not ignored.
#[test]
fn budgets_are_refused() {
    let there = painted("wrap_repeat");
    let upload = || Upload::single("mesh_colors.glb", file(&there, "mesh_colors.glb").to_vec());
    let refused = [
        (Options { texels: Some(1000), ..Options::default() }, "/texels"),
        (Options { max_error: Some(2.0), ..Options::default() }, "/max-error"),
    ];
    for (options, pointer) in refused {
        let error = converted(&upload(), &options, &Limits::default()).err().unwrap();
        assert_eq!((error.code, error.pointer.as_deref()), (ErrorCode::InvalidOptions, Some(pointer)));
    }
}

/// A GLB with another JSON and the same binary chunk.
fn edited(glb: &[u8], edit: &dyn Fn(&mut Value)) -> Vec<u8> {
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let rest = &glb[20 + word(12)..];
    let mut json: Value = serde_json::from_slice(&glb[20..20 + word(12)]).unwrap();
    edit(&mut json);
    let mut text = serde_json::to_vec(&json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut made = glb[..8].to_vec();
    for length in [20 + text.len() + rest.len(), text.len()] {
        made.extend((length as u32).to_le_bytes());
    }
    made.extend(&glb[16..20]);
    made.extend(text);
    made.extend(rest);
    made
}

/// An edit, and words of the place and of the reason that the error has to have.
type Mistake = (&'static str, fn(&mut Value), &'static str, &'static str);

const MISTAKES: &[Mistake] = &[
    (
        "no exponents",
        |own| drop(own.as_object_mut().unwrap().remove("exponents")),
        "/MCT_mesh_colors",
        "`exponents` is missing",
    ),
    (
        "exponents of another count",
        |own| own["exponents"] = own["channels"][0]["samples"].clone(),
        "/accessors/",
        "exponents must be Vec2",
    ),
    (
        "an accessor that is not there",
        |own| own["exponents"] = 999.into(),
        "/exponents",
        "999 is out of range",
    ),
    (
        "partners of another count",
        |own| own["partners"] = 0.into(),
        "/accessors/0",
        "partners must be Scalar",
    ),
    ("no channels", |own| own["channels"] = json!([]), "/MCT_mesh_colors", "`channels` is missing or empty"),
    (
        "an unknown slot",
        |own| own["channels"][0]["slots"] = json!(["sheen"]),
        "/channels/0",
        "is not a slot; slots are",
    ),
    ("no slot", |own| own["channels"][0]["slots"] = json!([]), "/channels/0", "at least one slot"),
    (
        "a slot twice",
        |own| own["channels"][0]["slots"] = json!(["normalTexture", "normalTexture"]),
        "/channels/0",
        "each once",
    ),
    (
        "a normal beside color",
        |own| own["channels"][0]["slots"] = json!(["baseColorTexture", "normalTexture"]),
        "/channels/0",
        "one kind of thing",
    ),
    (
        "color beside data",
        |own| own["channels"][0]["slots"] = json!(["baseColorTexture", "occlusionTexture"]),
        "/channels/0",
        "one kind of thing",
    ),
    (
        "a slot in two channels",
        |own| {
            let first = own["channels"][0].clone();
            own["channels"].as_array_mut().unwrap().push(first);
        },
        "/channels/1",
        "in another channel",
    ),
    (
        "five components",
        |own| own["channels"][0]["components"] = 5.into(),
        "/channels/0",
        "`components` is 5; allowed: 1, 2, 3, 4",
    ),
    (
        "one component",
        |own| own["channels"][0]["components"] = 1.into(),
        "/accessors/",
        "samples must be Scalar",
    ),
    (
        "twelve bits",
        |own| own["channels"][0]["bits"] = 12.into(),
        "/channels/0",
        "`bits` is 12; allowed: 8, 16",
    ),
    (
        "no samples",
        |own| drop(own["channels"][0].as_object_mut().unwrap().remove("samples")),
        "/channels/0",
        "`samples` is missing",
    ),
    (
        "cuts that are samples",
        |own| own["channels"][0]["cuts"] = own["channels"][0]["samples"].clone(),
        "/accessors/",
        "cuts must be",
    ),
    (
        "cuts of another count",
        |own| own["channels"][0]["cuts"] = own["quads"].clone(),
        "/channels/0/cuts",
        "entries; ",
    ),
];

/// What a file says wrong is refused with its place, and nothing panics.
#[test]
fn mistakes_have_their_place() {
    let there = painted("obj_quad_and_triangle");
    let glb = file(&there, "mesh_colors.glb");
    let read = |glb: Vec<u8>| {
        check(&Upload::single("mesh_colors.glb", glb), &Options::default(), &Limits::default(), &Unwatched)
    };
    let report = read(edited(glb, &|_| {})).unwrap();
    assert_eq!((report.kind, report.mesh_colors.len()), (SubjectKind::MeshColors, 1));
    for (what, mistake, place, reason) in MISTAKES {
        let edit = |json: &mut Value| {
            let quads = json["meshes"][0]["primitives"][0]["extensions"]["MCT_mesh_colors"]["quads"].clone();
            let own = &mut json["materials"][0]["extensions"]["MCT_mesh_colors"];
            own["quads"] = quads;
            mistake(own);
        };
        let error = read(edited(glb, &edit)).err().unwrap_or_else(|| panic!("{what} is read"));
        let pointer = error.pointer.clone().unwrap_or_default();
        assert!(
            error.code == ErrorCode::InvalidModel && pointer.contains(place) && error.detail.contains(reason),
            "{what}: {error}"
        );
    }
}

/// Samples that are too few or too many for the faces are told by count.
#[test]
fn samples_are_counted() {
    let there = painted("obj_quad_and_triangle");
    let edit = |json: &mut Value| {
        let samples = json["materials"][0]["extensions"]["MCT_mesh_colors"]["channels"][0]["samples"].clone();
        let accessor = &mut json["accessors"][samples.as_u64().unwrap() as usize];
        accessor["count"] = (accessor["count"].as_u64().unwrap() - 1).into();
    };
    let upload = Upload::single("mesh_colors.glb", edited(file(&there, "mesh_colors.glb"), &edit));
    let error = converted(&upload, &Options::default(), &Limits::default()).err().unwrap();
    assert_eq!(error.pointer.as_deref(), Some("/materials/0"));
    assert!(error.detail.contains("samples, and ") && error.detail.contains("baseColorTexture"), "{error}");
}

/// What no texture slot can hold is told, and taken as the nearest that it can.
#[test]
fn samples_out_of_range_are_told() {
    let there = painted("obj_quad_and_triangle");
    let mut glb = file(&there, "mesh_colors.glb").to_vec();
    assert_eq!(there.report.warnings.len(), 0);
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&glb[20..20 + word(12)]).unwrap();
    let samples = &json["materials"][0]["extensions"]["MCT_mesh_colors"]["channels"][0]["samples"];
    let view = &json["accessors"][samples.as_u64().unwrap() as usize]["bufferView"];
    let view = &json["bufferViews"][view.as_u64().unwrap() as usize];
    let first = 28 + word(12) + view["byteOffset"].as_u64().unwrap() as usize;
    glb[first..first + 4].copy_from_slice(&9.0f32.to_le_bytes());
    let upload = Upload::single("mesh_colors.glb", glb);
    let options = Options { mesh_colors: true, ..Options::default() };
    let back = converted(&upload, &options, &Limits::default()).unwrap();
    let codes: Vec<_> = back.report.warnings.iter().map(|warning| warning.code.as_str()).collect();
    assert_eq!(codes, ["mesh_color_out_of_range"]);
    let again = Upload::single("mesh_colors.glb", file(&back, "mesh_colors.glb").to_vec());
    assert!(converted(&again, &options, &Limits::default()).unwrap().report.warnings.is_empty());
}

/// The script of docs/mesh_colors.md, as it stands there.
#[test]
fn the_cube_of_the_docs_converts() {
    let page = meshcolor_tests::repository::file("docs/mesh_colors.md");
    let script = page.split_once("<!-- cube -->").and_then(|(_, rest)| rest.split_once("```python\n"));
    let (script, _) = script.and_then(|(_, rest)| rest.split_once("```")).expect("the page has the script");
    let folder = tempfile::tempdir().unwrap();
    let Ok(status) = Command::new("python3").args(["-c", script]).current_dir(folder.path()).status() else {
        assert!(!meshcolor_tests::requires_tools(), "python3 is missing");
        println!("skipped: the cube (no python3)");
        return;
    };
    assert!(status.success());
    let glb = std::fs::read(folder.path().join("cube.glb")).unwrap();
    validator::expect_valid("cube", &glb, false);
    let upload = Upload::single("cube.glb", glb);
    let cube = converted(&upload, &Options::default(), &Limits::default()).unwrap();
    validator::expect_valid("cube, converted", file(&cube, "asset.glb"), false);
    // Color is place, and at corners 0 and 1 are codes too.
    let positions = &cube.asset.meshes[0].primitives[0].positions;
    for primitive in &cube.finished.primitives {
        for (number, triangle) in primitive.triangles.iter().enumerate() {
            for k in 0..3 {
                let shown = shown_codes_of(&cube.finished.textures[0], 0, primitive.place(number, k, 0));
                let wanted = (positions[triangle.vertices[k] as usize] * 0.5 + 0.5) * 255.0;
                assert!(shown.abs_diff_eq(wanted, 1e-3), "triangle {number}: {shown}, not {wanted}");
            }
        }
    }
}
