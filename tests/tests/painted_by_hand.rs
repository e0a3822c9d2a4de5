//! Mesh colors whose triangles are partners, written by another hand as docs/mesh_colors.md defines the order of samples.

use glam::Vec3;
use meshcolor::pipeline::{Conversion, Options, convert};
use meshcolor::read::{Limits, Upload};
use meshcolor::watch::Unwatched;
use meshcolor_tests::gltf::Gltf;
use meshcolor_tests::reading::shown_codes_of;
use serde_json::json;

/// A unit square, around.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// Of the quad: four segments along edges 0 and 2, two along 1 and 3.
const EXPONENTS: [u8; 2] = [2, 1];
/// A slot whose samples are stored as they are.
const DATA: &str = "metallicRoughnessTexture";
/// 8-bit codes and their rounding.
const CODES: f32 = 0.6;

/// What is painted: data that a place tells.
fn painted(place: Vec3) -> Vec3 {
    Vec3::new(0.1, 0.2, 0.5) + place * Vec3::new(0.8, 0.6, 0.0)
}

fn mix(from: Vec3, to: Vec3, part: usize, parts: usize) -> Vec3 {
    from.lerp(to, part as f32 / parts as f32)
}

/// Places of the samples of two partners, of which `first` comes first.
fn places(first: [u32; 3], second: [u32; 3]) -> Vec<Vec3> {
    // Vertices have the numbers in which faces of the model use them.
    let mut numbers: Vec<u32> = Vec::new();
    for vertex in first.into_iter().chain(second) {
        if !numbers.contains(&vertex) {
            numbers.push(vertex);
        }
    }
    let number = |vertex: u32| numbers.iter().position(|known| *known == vertex);
    // The quad's corners: from the far end of the common edge around the first triangle, then what is left.
    let common = (0..3).find(|k| [*k, (k + 1) % 3].iter().all(|end| second.contains(&first[*end])));
    let k = common.expect("a common edge");
    let last = second.into_iter().find(|vertex| !first.contains(vertex)).expect("a fourth vertex");
    let ring = [first[(k + 1) % 3], first[(k + 2) % 3], first[k], last];
    let place = |vertex: u32| Vec3::from_array(CORNERS[vertex as usize]);
    let mut places: Vec<Vec3> = ring.map(place).to_vec();
    for edge in 0..4 {
        let mut ends = [ring[edge], ring[(edge + 1) % 4]];
        ends.sort_by_key(|end| number(*end));
        let parts = 1 << EXPONENTS[edge % 2];
        places.extend((1..parts).map(|part| mix(place(ends[0]), place(ends[1]), part, parts)));
    }
    let [n, m] = EXPONENTS.map(|exponent| 1 << exponent);
    let [a, b, c, d] = ring.map(place);
    for row in 1..m {
        places.extend((1..n).map(|column| mix(mix(a, b, column, n), mix(d, c, column, n), row, m)));
    }
    places
}

/// Triangles over the square's corners. `exponents` are of all of them, or of each two as partners.
fn square(triangles: &[[u32; 3]], slot: &str, exponents: &[[u8; 2]], samples: &[Vec3]) -> Upload {
    let mut gltf = Gltf::default();
    let is_paired = exponents.len() < triangles.len();
    let partners: Vec<u32> =
        (0..triangles.len() as u32).map(|number| number ^ u32::from(is_paired)).collect();
    let samples: Vec<f32> = samples.iter().flat_map(|sample| sample.to_array()).collect();
    let colors = json!({
        "partners": gltf.indices(&partners),
        "exponents": gltf.accessor("VEC2", 5121, exponents.as_flattened(), false),
        "channels": [{
            "slots": [slot], "components": 3, "bits": 8, "samples": gltf.floats("VEC3", &samples),
        }],
    });
    let material = gltf.material(json!({ "extensions": { "MCT_mesh_colors": colors } }));
    let positions = gltf.positions(&CORNERS);
    let indices = gltf.indices(triangles.as_flattened());
    gltf.primitive(
        json!({ "attributes": { "POSITION": positions }, "indices": indices, "material": material }),
    );
    gltf.json["extensionsUsed"] = json!(["MCT_mesh_colors"]);
    Upload::single("square.glb", gltf.glb())
}

fn converted(upload: &Upload) -> Conversion {
    convert(upload, &Options::default(), &Limits::default(), &Unwatched).unwrap()
}

/// How many of a warning a conversion has.
fn told(upload: &Upload, code: &str) -> u64 {
    let warnings = converted(upload).report.warnings;
    warnings.iter().filter(|warning| warning.code == code).map(|warning| warning.count).sum()
}

#[test]
fn edges_run_as_the_page_says() {
    let turned = |mut triangle: [u32; 3], by: usize| {
        triangle.rotate_left(by);
        triangle
    };
    let halves = [([0, 1, 2], [0, 2, 3]), ([0, 2, 3], [0, 1, 2])];
    for (first, second) in halves {
        for (one, other) in (0..3).flat_map(|one| (0..3).map(move |other| (one, other))) {
            let (first, second) = (turned(first, one), turned(second, other));
            let samples: Vec<Vec3> = places(first, second).into_iter().map(painted).collect();
            let conversion = converted(&square(&[first, second], DATA, &[EXPONENTS], &samples));
            let positions = &conversion.asset.meshes[0].primitives[0].positions;
            let piece = &conversion.finished.primitives[0];
            for (number, triangle) in piece.triangles.iter().enumerate() {
                for (s, t) in (0..=8).flat_map(|s| (0..=8 - s).map(move |t| (s, t))) {
                    let at = Vec3::new((8 - s - t) as f32, s as f32, t as f32) / 8.0;
                    let place: Vec3 = (0..3).map(|k| positions[triangle.vertices[k] as usize] * at[k]).sum();
                    let shown =
                        shown_codes_of(&conversion.finished.textures[0], 0, piece.place_at(number, at, 0));
                    let wanted = painted(place) * 255.0;
                    assert!(
                        shown.abs_diff_eq(wanted, CODES),
                        "{first:?} {second:?}, {place}: {shown}, not {wanted}"
                    );
                }
            }
        }
    }
}

#[test]
fn triangles_alone_tell_what_they_cost() {
    // A front and a back, so that every edge has two sides.
    let both = &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    // Whichever corner the first triangle's half square lacks, what lies there has a component of 0 + 0 - 1.
    let samples = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ZERO];
    assert_eq!(told(&square(both, DATA, &[[0; 2]; 4], &samples), "samples_changed"), 1);
    assert_eq!(told(&square(both, DATA, &[[0; 2]; 2], &samples), "samples_changed"), 0, "partners");
    let samples = samples.map(|sample| sample * 0.3 + 0.3);
    assert_eq!(told(&square(both, DATA, &[[0; 2]; 4], &samples), "samples_changed"), 0, "away from 0 and 1");
}

#[test]
fn normals_that_are_none_are_told() {
    let halves = [[0, 1, 2], [0, 2, 3]];
    for (normal, count) in
        [(Vec3::Z, 0), (Vec3::new(0.0, 0.6, 0.8), 0), (Vec3::ZERO, 1), (Vec3::new(3.0, 4.0, 0.0), 1)]
    {
        let upload = square(&halves, "normalTexture", &[[0; 2]], &[Vec3::Z, Vec3::Z, normal, Vec3::Z]);
        assert_eq!(told(&upload, "mesh_color_not_unit"), count, "{normal}");
    }
}
