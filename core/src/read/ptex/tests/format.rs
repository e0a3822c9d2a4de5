//! Field by field: what the format's description says is what is read.

use super::*;
use crate::math::transfer::srgb_to_linear;

/// One face of `8 x 4` texels with distinct numbers.
fn one(data: u32, channels: usize, stored: Stored) -> Ptex {
    let most = match data {
        writer::U8 => 256,
        writer::U16 => 65536,
        _ => 1024,
    };
    let scale = if data >= writer::HALF { 1.0 / 1024.0 } else { 1.0 };
    let mut random = Random(42 + u64::from(data));
    let numbers = (0..32 * channels).map(|_| random.below(most) as f32 * scale).collect();
    let face = Face { log2: [3, 2], neighbours: [None; 4], is_subface: false, stored, numbers };
    Ptex { is_triangles: false, data, channels, alpha: None, faces: vec![face] }
}

fn read_one(file: &Ptex, kind: Kind) -> Result<(Painted, Vec<Warning>)> {
    read_as(&file.bytes(), &[vec![0, 1, 2, 3]], kind, &Limits::default())
}

/// The components of a texel of the only face, as the image has them.
fn texel(painted: &Painted, u: u32, v: u32) -> Vec4 {
    let size = Vec2::new(painted.image.width as f32, painted.image.height as f32);
    let [x, y] = [(2 * u + 1) as f32, (2 * v + 1) as f32];
    let at = painted.texcoords[0] * size + Vec2::new(x, -y);
    bilinear(&painted.image, Transfer::Linear, Wrap::default(), at)
}

#[test]
fn all_data_types_and_encodings() {
    for data in [writer::U8, writer::U16, writer::HALF, writer::FLOAT] {
        for stored in [Stored::Zipped, Stored::DiffZipped, Stored::Tiled([1, 0]), Stored::Tiled([2, 1])] {
            let file = one(data, 3, stored);
            let (painted, warnings) = read_one(&file, Kind::Color).unwrap();
            assert_eq!(warnings, []);
            let bits = if data == writer::U8 { 8 } else { 16 };
            assert_eq!((painted.image.bits(), painted.image.components), (bits, 3));
            for v in 0..4 {
                for u in 0..8 {
                    let numbers = &file.faces[0].numbers[(v * 8 + u) * 3..][..3];
                    let expected = [0, 1, 2].map(|k| match data {
                        writer::U8 => srgb_to_linear(numbers[k] / 255.0),
                        writer::U16 => srgb_to_linear(numbers[k] / 65535.0),
                        _ => numbers[k],
                    });
                    let found = texel(&painted, u as u32, v as u32);
                    assert!((found.truncate() - glam::Vec3::from(expected)).abs().max_element() < 1e-6);
                }
            }
        }
    }
}

/// v points up: corner 0 is at the bottom left of its chart, edges are bottom, right, top, left.
#[test]
fn corners_stand_where_the_format_has_them() {
    let (painted, _) = read_one(&one(writer::U8, 1, Stored::Zipped), Kind::Color).unwrap();
    let [a, b, c, d] = painted.texcoords[..] else { panic!("four corners") };
    assert!(a.x < b.x && a.y == b.y && c.x == b.x && c.y < b.y && d == Vec2::new(a.x, c.y));
    let size = Vec2::new(painted.image.width as f32, painted.image.height as f32);
    assert!(((c - a) * size).abs().abs_diff_eq(Vec2::new(16.0, 8.0), 1e-5));
}

#[test]
fn constants_have_one_texel() {
    for stored in [Stored::Flagged, Stored::Constant] {
        let file = one(writer::U8, 4, stored);
        let (painted, _) = read_one(&file, Kind::Color).unwrap();
        let expected = srgb_to_linear(file.faces[0].numbers[1] / 255.0);
        for (u, v) in [(0, 0), (7, 3), (4, 2)] {
            let found = texel(&painted, u, v);
            assert!((found.y - expected).abs() < 1e-6, "{stored:?}: {found}");
            assert!((found.w - file.faces[0].numbers[3] / 255.0).abs() < 1e-6, "alpha is linear");
        }
    }
}

/// Channels of the file, its alpha, the components taken, and how many were left out.
#[test]
fn channels_become_components() {
    let cases: [(usize, Option<u32>, &[usize], u64); 9] = [
        (1, None, &[0], 0),
        (2, None, &[0, 1], 0),
        (2, Some(0), &[1, 0], 0),
        (3, None, &[0, 1, 2], 0),
        (3, Some(1), &[0, 1], 1),
        (4, None, &[0, 1, 2, 3], 0),
        (4, Some(0), &[1, 2, 3, 0], 0),
        (6, None, &[0, 1, 2], 3),
        (6, Some(5), &[0, 1, 2, 5], 2),
    ];
    for (channels, alpha, taken, left_out) in cases {
        let file = Ptex { alpha, ..one(writer::U16, channels, Stored::Zipped) };
        // As data, so that all channels are linear.
        let (painted, warnings) = read_one(&file, Kind::Normal).unwrap();
        assert_eq!(usize::from(painted.image.components), taken.len());
        let found: Vec<_> = warnings.iter().map(|warning| (warning.code.as_str(), warning.count)).collect();
        let expected = if left_out > 0 { vec![("ptex_channels", left_out)] } else { vec![] };
        assert_eq!(found, expected, "{channels} {alpha:?}");
        let value = texel(&painted, 2, 1);
        let number = |channel: usize| file.faces[0].numbers[10 * channels + channel] / 65535.0;
        for (component, &channel) in taken.iter().enumerate() {
            let place = if taken.len() == 2 && component == 1 { 3 } else { component };
            assert!((value[place] - number(channel)).abs() < 1e-6, "{channels} {alpha:?} {component}");
        }
    }
}

#[test]
fn values_outside_are_clamped_and_told() {
    let mut file = one(writer::FLOAT, 1, Stored::Zipped);
    file.faces[0].numbers[0] = -0.5;
    file.faces[0].numbers[1] = 7.25;
    file.faces[0].numbers[2] = f32::NAN;
    file.faces[0].numbers[3] = f32::INFINITY;
    let (painted, warnings) = read_one(&file, Kind::Color).unwrap();
    assert_eq!([0, 1, 2, 3].map(|u| texel(&painted, u, 0).x), [0.0, 1.0, 0.0, 1.0]);
    let found: Vec<_> = warnings.iter().map(|warning| (warning.code.as_str(), warning.count)).collect();
    assert_eq!(found, [("ptex_range", 3), ("ptex_not_a_number", 1)]);
    assert!(warnings[0].detail.contains("from -0.5 to inf"), "{}", warnings[0].detail);
}

#[test]
fn neighbours_that_the_mesh_lacks_are_counted() {
    let mut random = Random(1);
    let faces = vec![vec![0, 1, 2, 3], vec![1, 4, 5, 2]];
    let mut model = Model::random(faces, writer::U8, &mut random, |_| [1, 1]);
    assert_eq!(model.read().unwrap().1, []);
    model.file.faces[0].neighbours[1] = Some((1, 2));
    model.file.faces[1].neighbours[3] = None;
    model.file.faces[1].neighbours[0] = Some((0, 0));
    let warnings = model.read().unwrap().1;
    assert_eq!((warnings[0].code.as_str(), warnings[0].count), ("ptex_adjacency", 3));
    let detail = &warnings[0].detail;
    assert!(
        detail.contains("edge 1 of face 0: the file has edge 2 of face 1, the mesh edge 3 of face 1"),
        "{detail}"
    );
}

#[test]
fn edits_are_told() {
    let file = one(writer::U8, 3, Stored::Zipped);
    let mut bytes = file.bytes();
    // The size of the edits in the extended header.
    bytes[64 + 24] = 1;
    let edited = read_as(&bytes, &[vec![0, 1, 2, 3]], Kind::Color, &Limits::default()).unwrap().1;
    assert_eq!(edited[0].code, "ptex_edits");
    // Before version 1.3 there was no such size: edits stood at the end.
    let mut old = file.bytes();
    old[28..32].copy_from_slice(&0u32.to_le_bytes());
    old.drain(64..104);
    assert_eq!(read_as(&old, &[vec![0, 1, 2, 3]], Kind::Color, &Limits::default()).unwrap().1, []);
    let end = old.len() - 8;
    old[end..end + 5].copy_from_slice(&[1, 3, 0, 0, 0]);
    let edited = read_as(&old, &[vec![0, 1, 2, 3]], Kind::Color, &Limits::default()).unwrap().1;
    assert_eq!(edited[0].code, "ptex_edits");
}

/// Reductions are levels behind the first.
#[test]
fn further_levels_are_left_alone() {
    let file = one(writer::U8, 3, Stored::Zipped);
    let mut bytes = file.bytes();
    let word = |bytes: &[u8], at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let levels = 64 + (word(&bytes, 28) + word(&bytes, 32) + word(&bytes, 36)) as usize;
    bytes.splice(levels + 16..levels + 16, [0; 16]);
    bytes[40] = 32;
    bytes[22] = 2;
    let level_bytes = word(&bytes, 48);
    let end = levels + 32 + level_bytes as usize;
    bytes.splice(end..end, *b"whatever a reduction may be");
    bytes[48..52].copy_from_slice(&(level_bytes + 27).to_le_bytes());
    let faces = [vec![0, 1, 2, 3]];
    let (painted, warnings) = read_as(&bytes, &faces, Kind::Color, &Limits::default()).unwrap();
    assert_eq!((painted.image, warnings), (read_one(&file, Kind::Color).unwrap().0.image, vec![]));
}
