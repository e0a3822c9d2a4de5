//! `--geometry`: what is packed is there again, exactly where it has to be.

use std::path::Path;

use meshcolor::asset::{Asset, Primitive};
use meshcolor::measure::Verdict;
use meshcolor::pipeline::{Coordinates, GeometryFormat, Options, check, convert};
use meshcolor::read::{Limits, Upload, read};
use meshcolor::watch::Unwatched;
use meshcolor_tests::cases::{self, Case};
use meshcolor_tests::{models, validator};

/// Materials in parts and over meshes, tangents, skins, morph targets, lines, several sets of coordinates.
const CASES: [&str; 8] = [
    "lines_and_plain_material",
    "material_over_two_meshes",
    "normal_with_tangent",
    "obj_quad_and_triangle",
    "obj_vertex_colors",
    "primitives_weld",
    "skin_morph_animation",
    "slots_of_two_sets",
];

fn converted(upload: &Upload, geometry: GeometryFormat, coordinates: Coordinates) -> Vec<u8> {
    let options = Options { geometry, coordinates, ..Options::default() };
    let conversion = convert(upload, &options, &Limits::default(), &Unwatched).unwrap();
    conversion.files.into_iter().find(|file| file.path == "asset.glb").unwrap().bytes
}

fn asset(glb: &[u8]) -> Asset {
    read(&Upload::single("asset.glb", glb.to_vec()), &Limits::default(), &Unwatched).unwrap()
}

fn primitives(asset: &Asset) -> Vec<&Primitive> {
    asset.meshes.iter().flat_map(|mesh| &mesh.primitives).collect()
}

/// The report of a converted file, apart from its options.
fn judged(glb: &[u8]) -> meshcolor::measure::Report {
    let upload = Upload::single("asset.glb", glb.to_vec());
    check(&upload, &Options::default(), &Limits::default(), &Unwatched).unwrap()
}

fn expect_packed(name: &str, upload: &Upload, coordinates: Coordinates) {
    let plain = converted(upload, GeometryFormat::Plain, coordinates);
    let packed = converted(upload, GeometryFormat::Meshopt, coordinates);
    let rounded = converted(upload, GeometryFormat::Quantized, coordinates);
    for glb in [&packed, &rounded] {
        validator::expect_valid(name, glb, false);
    }
    let [before, exact, near] = [&plain, &packed, &rounded].map(|glb| asset(glb));
    for ((before, exact), near) in
        primitives(&before).into_iter().zip(primitives(&exact)).zip(primitives(&near))
    {
        assert_eq!(before.faces, exact.faces, "{name}");
        assert_eq!(before.faces, near.faces, "{name}");
        assert_eq!(before.positions, exact.positions, "{name}");
        assert_eq!(before.normals, exact.normals, "{name}");
        assert_eq!(before.tangents, exact.tangents, "{name}");
        assert_eq!(before.texcoords, exact.texcoords, "{name}");
        assert_eq!(before.attributes, exact.attributes, "{name}");
        assert_eq!(before.targets, exact.targets, "{name}");
        // Coordinates and everything else but vectors keep their bits; so do positions that were equal.
        assert_eq!(before.attributes, near.attributes, "{name}");
        if before.attributes.iter().any(|attribute| attribute.semantic.starts_with("_MCT_")) {
            assert_eq!(before.texcoords[0], near.texcoords[0], "{name}");
        }
        for (before, near) in before.positions.iter().zip(&near.positions) {
            let allowed = before.abs() / 32768.0;
            assert!((*before - *near).abs().cmple(allowed).all(), "{name}: {before} {near}");
        }
        for (before, near) in before.normals.iter().zip(&near.normals) {
            assert!(before.angle_between(*near).to_degrees() < 0.03, "{name}: {before} {near}");
        }
    }
    let [before, exact, near] = [&plain, &packed, &rounded].map(|glb| judged(glb));
    assert_eq!((&before.channels, &before.layouts), (&exact.channels, &exact.layouts), "{name}");
    assert_eq!(before.channels.len(), near.channels.len(), "{name}");
    assert_eq!(before.verdict == Verdict::Fail, near.verdict == Verdict::Fail, "{name}");
    assert!(near.max_seam_delta_codes <= before.max_seam_delta_codes + 0.01, "{name}");
}

#[test]
fn coordinates_stay_exact_and_all_else_is_as_near_as_said() {
    for case in CASES {
        let folder = cases::folder().join(case);
        let upload = || Case::load(Path::new(&folder)).upload(&folder);
        for coordinates in [Coordinates::Indexed, Coordinates::Scaled] {
            expect_packed(case, &upload(), coordinates);
        }
    }
}

#[test]
fn packed_geometry_is_smaller() {
    let Some(helmet) = models::upload("DamagedHelmet") else { return };
    // Few texels: the vertices are what counts.
    let size = |geometry| {
        let options = Options { geometry, ..Options::default() };
        let options = Options { resolution: meshcolor::pipeline::Resolution::Fixed(0), ..options };
        let conversion = convert(&helmet, &options, &Limits::default(), &Unwatched).unwrap();
        conversion.files[0].bytes.len()
    };
    let sizes = [GeometryFormat::Plain, GeometryFormat::Meshopt, GeometryFormat::Quantized].map(size);
    println!("DamagedHelmet with a texel a vertex: {sizes:?} bytes plain, packed, rounded and packed");
    assert!(sizes[1] < sizes[0] && sizes[2] < sizes[1]);
}
