//! Both sides of every edge show the same, and inside of a face it is the filter that the format means.

use super::*;
use crate::math::transfer::SRGB8_TO_LINEAR;

/// Rounding of single precision, of values up to 1.
const ROUNDING: f32 = 2e-5;

fn cube() -> Vec<Vec<u32>> {
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]].map(Vec::from).into()
}

/// Quads around a vertex.
fn fan(count: u32) -> Vec<Vec<u32>> {
    (0..count).map(|k| vec![0, 1 + 2 * k, 2 + 2 * k, 1 + 2 * ((k + 1) % count)]).collect()
}

fn grid(side: u32) -> Vec<Vec<u32>> {
    let at = |x: u32, y: u32| y * (side + 1) + x;
    let quad = |k: u32| {
        let (x, y) = (k % side, k / side);
        vec![at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]
    };
    (0..side * side).map(quad).collect()
}

fn octahedron() -> Vec<Vec<u32>> {
    let around = [1, 2, 3, 4];
    (0..4)
        .flat_map(|k| [[0, around[k], around[(k + 1) % 4]], [5, around[(k + 1) % 4], around[k]]])
        .map(Vec::from)
        .collect()
}

fn triangle_fan(count: u32) -> Vec<Vec<u32>> {
    (0..count).map(|k| vec![0, 1 + k, 1 + (k + 1) % count]).collect()
}

/// Begins faces at other corners, and turns some over.
fn turned(mut faces: Vec<Vec<u32>>, random: &mut Random) -> Vec<Vec<u32>> {
    for face in &mut faces {
        let by = random.below(face.len());
        face.rotate_left(by);
        if random.below(5) == 0 {
            face.reverse();
        }
    }
    faces
}

/// The place of a point of an edge, by its share from the edge's first corner.
fn on_edge(corner_count: usize, edge: usize, share: f32) -> [f32; 2] {
    let corners: &[[f32; 2]] = match corner_count {
        3 => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        _ => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
    };
    let [from, to] = [corners[edge], corners[(edge + 1) % corner_count]];
    [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * share)
}

/// The largest difference between any two sides of any edge, and how many pairs were looked at.
fn largest_step(model: &Model, painted: &Painted) -> (f32, usize) {
    let (mut largest, mut pairs) = (0.0f32, 0);
    let sides = || {
        let all = model.faces.iter().enumerate();
        all.flat_map(|(number, face)| {
            (0..face.len()).map(move |edge| (number, edge, face[edge], face[(edge + 1) % face.len()]))
        })
    };
    for (a, edge_a, from_a, to_a) in sides() {
        for (b, edge_b, from_b, to_b) in sides().filter(|side| side.0 > a) {
            let is_same = (from_a, to_a) == (from_b, to_b);
            if !is_same && (from_a, to_a) != (to_b, from_b) {
                continue;
            }
            pairs += 1;
            for step in 0..=97 {
                let share = step as f32 / 97.0;
                let [s, t] = on_edge(model.faces[a].len(), edge_a, share);
                let [x, y] = on_edge(model.faces[b].len(), edge_b, if is_same { share } else { 1.0 - share });
                let difference = model.at(painted, a, s, t) - model.at(painted, b, x, y);
                largest = largest.max(difference.abs().max_element());
            }
        }
    }
    (largest, pairs)
}

#[test]
fn sides_agree_whatever_their_resolutions_and_valences() {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    for round in 0..60 {
        let faces = match round % 6 {
            0 => cube(),
            1 => grid(3),
            k => fan(k as u32 + 1),
        };
        let faces = turned(faces, &mut random);
        let data = random.below(4) as u32;
        let model = Model::random(faces, data, &mut random, |r| [r.below(5) as u8, r.below(5) as u8]);
        let (painted, warnings) = model.read().unwrap();
        assert_eq!(warnings, [], "round {round}");
        let (step, pairs) = largest_step(&model, &painted);
        assert!(step < ROUNDING && pairs >= 3, "round {round}: {step} over {pairs} pairs");
    }
}

#[test]
fn triangles_agree_too() {
    let mut random = Random(0x1234_5678_9ABC_DEF1);
    for round in 0..60 {
        let faces = match round % 5 {
            0 => octahedron(),
            k => triangle_fan(k as u32 + 2),
        };
        let faces = turned(faces, &mut random);
        let data = random.below(4) as u32;
        let model = Model::random(faces, data, &mut random, |r| [r.below(5) as u8; 2]);
        let (painted, warnings) = model.read().unwrap();
        assert_eq!(warnings, [], "round {round}");
        let (step, pairs) = largest_step(&model, &painted);
        assert!(step < ROUNDING && pairs >= 3, "round {round}: {step} over {pairs} pairs");
    }
}

/// Faces of normals keep what they have: their frames differ.
#[test]
fn normals_are_not_joined() {
    let mut random = Random(77);
    let model = Model::random(grid(2), writer::U8, &mut random, |_| [2, 2]);
    let (painted, _) = read_as(&model.file.bytes(), &model.faces, Kind::Normal, &Limits::default()).unwrap();
    assert!(largest_step(&model, &painted).0 > 0.1);
    let corner = model.at(&painted, 0, 0.0, 0.0).x;
    assert!((corner - model.file.faces[0].numbers[0] / 255.0).abs() < ROUNDING);
}

/// A plane of equal faces is one picture, and its filter is the picture's bilinear one, also across edges and at inner vertices.
#[test]
fn a_plane_of_faces_is_filtered_as_one_picture() {
    const SIDE: usize = 3;
    let mut random = Random(5);
    for log2 in [[0, 0], [2, 2], [3, 1], [1, 4]] {
        let model = Model::random(grid(SIDE as u32), writer::U8, &mut random, |_| log2);
        let (painted, _) = model.read().unwrap();
        let [n, m] = log2.map(|log2| 1usize << log2);
        let texel = |x: isize, y: isize| {
            let (x, y) = (x.clamp(0, (SIDE * n) as isize - 1), y.clamp(0, (SIDE * m) as isize - 1));
            let (x, y) = (x as usize, y as usize);
            let face = &model.file.faces[y / m * SIDE + x / n];
            let code = face.numbers[(y % m * n + x % n) * 3];
            SRGB8_TO_LINEAR[code as usize]
        };
        for _ in 0..2000 {
            let (s, t) = (random.below(1001) as f32 / 1000.0, random.below(1001) as f32 / 1000.0);
            let face = random.below(SIDE * SIDE);
            let x = ((face % SIDE) as f32 + s) * n as f32 - 0.5;
            let y = ((face / SIDE) as f32 + t) * m as f32 - 0.5;
            let (i, j) = (x.floor(), y.floor());
            let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
            let row = |j: isize| mix(texel(i as isize, j), texel(i as isize + 1, j), x - i);
            let expected = mix(row(j as isize), row(j as isize + 1), y - j);
            let found = model.at(&painted, face, s, t).x;
            assert!((found - expected).abs() < 1e-4, "{log2:?} {face} {s} {t}: {found} for {expected}");
        }
    }
}

/// Beside finer faces a coarse one shows what it would beside faces of its own resolution that were reduced to it.
#[test]
fn the_coarser_side_rules_the_edge() {
    let mut random = Random(11);
    let fine = Model::random(grid(3), writer::FLOAT, &mut random, |_| [3, 3]);
    let mut mixed = fine.file.clone();
    let mut coarse = fine.file.clone();
    for face in &mut coarse.faces {
        face.numbers = (0..2 * 2 * 3)
            .map(|k| {
                let (texel, channel) = (k / 3, k % 3);
                let at = |u: usize, v: usize| {
                    face.numbers[((texel / 2 * 4 + v) * 8 + texel % 2 * 4 + u) * 3 + channel]
                };
                (0..16).map(|k| at(k % 4, k / 4)).sum::<f32>() / 16.0
            })
            .collect();
        face.log2 = [1, 1];
    }
    mixed.faces[4] = coarse.faces[4].clone();
    let [mixed, coarse] = [mixed, coarse].map(|file| Model { faces: fine.faces.clone(), file });
    let [(of_mixed, _), (of_coarse, _)] = [&mixed, &coarse].map(|model| model.read().unwrap());
    for k in 0..=20 {
        for l in 0..=20 {
            // Near its corners fine faces meet each other, and are not reduced.
            let (s, t) = (k as f32 / 20.0, l as f32 / 20.0);
            if [s, t].into_iter().all(|share| !(0.25..=0.75).contains(&share)) {
                continue;
            }
            let difference = mixed.at(&of_mixed, 4, s, t) - coarse.at(&of_coarse, 4, s, t);
            assert!(difference.abs().max_element() < ROUNDING, "{s} {t}: {difference}");
        }
    }
}

/// Six texels meet at a vertex of the grid; a fetch on the slanted side reads beyond the face and stays linear.
#[test]
fn triangles_are_linear_between_means_of_six() {
    let mut random = Random(3);
    let model = Model::random(octahedron(), writer::FLOAT, &mut random, |_| [2, 2]);
    let (painted, _) = model.read().unwrap();
    const N: usize = 4;
    let stored = |u: usize, v: usize| model.file.faces[0].numbers[(v * N + u) * 3];
    let even = |a: usize, b: usize| stored(a, b);
    let odd = |a: usize, b: usize| stored(N - 1 - b, N - 1 - a);
    let expected = (even(1, 1) + even(0, 1) + even(1, 0) + odd(0, 0) + odd(0, 1) + odd(1, 0)) / 6.0;
    assert!((model.at(&painted, 0, 0.25, 0.25).x - expected).abs() < ROUNDING);
    // In the middle of a texel at the slanted side: the mean of its three vertices.
    let vertex = |i: usize, j: usize| model.at(&painted, 0, i as f32 / 4.0, j as f32 / 4.0).x;
    let middle = (vertex(1, 2) + vertex(2, 2) + vertex(1, 3)) / 3.0;
    assert!(
        (model.at(&painted, 0, (1.0 + 1.0 / 3.0) / 4.0, (2.0 + 1.0 / 3.0) / 4.0).x - middle).abs() < ROUNDING
    );
}

/// A corner of an extraordinary vertex shows the mean over all faces around it.
#[test]
fn vertices_show_the_mean_of_their_corners() {
    let mut random = Random(9);
    let model = Model::random(fan(5), writer::FLOAT, &mut random, |_| [1, 1]);
    let (painted, _) = model.read().unwrap();
    let mean = model.file.faces.iter().map(|face| face.numbers[0]).sum::<f32>() / 5.0;
    assert!((model.at(&painted, 3, 0.0, 0.0).x - mean).abs() < ROUNDING);
}
