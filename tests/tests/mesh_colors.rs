//! `MCT_mesh_colors`: converting what `--mesh-colors` wrote gives the `asset.glb` that the source gave.

use std::path::Path;

use meshcolor::pipeline::{Conversion, Options, convert};
use meshcolor::read::{Limits, Upload};
use meshcolor::watch::Unwatched;
use meshcolor::{Error, ErrorCode};
use meshcolor_tests::cases::{self, Case};
use meshcolor_tests::{hard, models, validator};

/// What their source has wrong stays: a material that reads a set of coordinates which a primitive lacks.
const FAULTY: [&str; 1] = ["texcoord_missing"];

fn file<'c>(conversion: &'c Conversion, path: &str) -> &'c [u8] {
    let file = conversion.files.iter().find(|file| file.path == path);
    &file.unwrap_or_else(|| panic!("there is no {path}")).bytes
}

fn converted(upload: &Upload, options: &Options, limits: &Limits) -> Result<Conversion, Error> {
    convert(upload, options, limits, &Unwatched)
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
    Some(Ok(()))
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

#[test]
fn with_4d_coordinates_too() {
    for name in ["Fox", "spot"] {
        let Some(upload) = models::upload(name) else { continue };
        let options = Options { coordinates: meshcolor::pipeline::Coordinates::Scaled, ..Options::default() };
        assert_eq!(trip(name, &upload, &options, &Limits::default()), Some(Ok(())));
    }
}

/// Mesh colors have their resolution, so options that ask for another are refused and not ignored.
#[test]
fn budgets_are_refused() {
    let folder = cases::folder().join("wrap_repeat");
    let case = Case::load(&folder);
    let options = Options { mesh_colors: true, ..Options::default() };
    let there = converted(&case.upload(&folder), &options, &Limits::default()).unwrap();
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
