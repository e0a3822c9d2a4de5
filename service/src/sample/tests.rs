//! The sample shows what it is for: no seam at level 0, plain seams further down.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};
use meshcolor::image::{Image, Pixels, Transfer, Wrap, bilinear};

use super::paint::{self, COLOR_SIDE, NORMAL_SIDE};
use super::shape::{ALONG, AROUND, ISLAND_COUNT, Island, Shape, Vertex, knot, triangles};

/// The two sides of every edge between islands, and of the edge along the tube inside each.
fn seams<'s>(shape: &'s Shape) -> Vec<[[&'s Vertex; 2]; 2]> {
    let mut seams = Vec::new();
    for (number, island) in shape.islands.iter().enumerate() {
        let next = &shape.islands[(number + 1) % ISLAND_COUNT];
        for j in 0..AROUND {
            let side = |island: &'s Island, i: usize| [island.vertex(i, j), island.vertex(i, j + 1)];
            seams.push([side(island, ALONG), side(next, 0)]);
        }
        for i in 0..ALONG {
            let side = |j: usize| [island.vertex(i, j), island.vertex(i + 1, j)];
            seams.push([side(0), side(AROUND)]);
        }
    }
    seams
}

/// Largest and mean jump over all seams, in codes.
fn jumps_codes(shape: &Shape, image: &Image) -> (f32, f32) {
    let mut jumps = Vec::new();
    for [here, there] in seams(shape) {
        for step in 0..=16 {
            let t = step as f32 / 16.0;
            // Stored codes are compared, so they are filtered as data.
            let value = |side: [&Vertex; 2]| {
                let at = side[0].uv.lerp(side[1].uv, t) * image.width as f32;
                bilinear(image, Transfer::Linear, Wrap::default(), at)
            };
            jumps.push((value(here) - value(there)).abs().max_element() * 255.0);
        }
    }
    (jumps.iter().copied().fold(0.0, f32::max), jumps.iter().sum::<f32>() / jumps.len() as f32)
}

fn half(image: &Image) -> Image {
    let (width, height, n) = (image.width / 2, image.height / 2, usize::from(image.components));
    let Pixels::U8(codes) = &image.pixels else { panic!("8 bits") };
    let mut halved = Vec::new();
    for y in 0..height as usize {
        for x in 0..width as usize {
            for k in 0..n {
                let code = |dx: usize, dy: usize| {
                    u32::from(codes[((2 * y + dy) * image.width as usize + 2 * x + dx) * n + k])
                };
                halved.push(((code(0, 0) + code(1, 0) + code(0, 1) + code(1, 1) + 2) / 4) as u8);
            }
        }
    }
    Image { width, height, components: image.components, pixels: Pixels::U8(halved) }
}

#[test]
fn both_sides_of_each_seam_are_the_same_edge() {
    for [here, there] in seams(&knot()) {
        for (a, b) in here.iter().zip(there) {
            assert_eq!(a.position.to_array(), b.position.to_array());
            assert_eq!(a.normal.to_array(), b.normal.to_array());
            assert!(a.uv.distance(b.uv) > 0.05);
        }
    }
}

#[test]
fn the_tube_is_closed_and_looks_outward() {
    let shape = knot();
    let bits = |p: Vec3| p.to_array().map(f32::to_bits);
    let mut edges: BTreeMap<[[u32; 3]; 2], i32> = BTreeMap::new();
    for island in &shape.islands {
        for triangle in triangles() {
            let corners = triangle.map(|v| &island.vertices[v]);
            let [a, b, c] = corners.map(|v| v.position);
            let normal = (b - a).cross(c - a);
            assert!(corners.iter().all(|v| v.normal.dot(normal) > 0.0));
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry([bits(from), bits(to)]).or_default() += 1;
            }
        }
    }
    for ([from, to], count) in &edges {
        assert_eq!((*count, edges.get(&[*to, *from])), (1, Some(&1)));
    }
}

#[test]
fn islands_keep_apart() {
    let shape = knot();
    for side in [COLOR_SIDE, NORMAL_SIDE] {
        for texel in 0..side * side {
            let uv = (Vec2::new((texel % side) as f32, (texel / side) as f32) + 0.5) / side as f32;
            let owners = shape.islands.iter().filter(|island| paint::is_painted(island, uv, side)).count();
            assert!(owners <= 1, "texel {texel} has {owners} owners");
        }
    }
    for vertex in shape.islands.iter().flat_map(|island| &island.vertices) {
        assert!(vertex.uv.min_element() > 0.0 && vertex.uv.max_element() < 1.0);
    }
}

#[test]
fn seams_agree_at_level_0_and_show_further_down() {
    let shape = knot();
    let level_0 = paint::base_color(&shape);
    let (max, mean) = jumps_codes(&shape, &level_0);
    assert!(max <= 4.0 && mean < 1.0, "level 0: max {max}, mean {mean}");
    let level_2 = half(&half(&level_0));
    let (max, mean) = jumps_codes(&shape, &level_2);
    assert!(max > 40.0 && mean > 10.0, "level 2: max {max}, mean {mean}");
    let (_, mean) = jumps_codes(&shape, &half(&level_2));
    assert!(mean > 15.0, "level 3: mean {mean}");
}

/// Tilt of a decoded normal, in the vertices' frames.
fn decoded(image: &Image, side: [&Vertex; 2], t: f32) -> Vec3 {
    let at = side[0].uv.lerp(side[1].uv, t) * image.width as f32;
    let stored = bilinear(image, Transfer::Linear, Wrap::default(), at).truncate() * 2.0 - 1.0;
    let normal = side[0].normal.lerp(side[1].normal, t).normalize();
    let tangent = side[0].tangent.lerp(side[1].tangent, t).truncate().normalize();
    (tangent * stored.x + normal.cross(tangent) * stored.y + normal * stored.z).normalize()
}

#[test]
fn normals_agree_across_seams_and_are_not_flat() {
    let shape = knot();
    let map = paint::normal_map(&shape);
    let (mut most, mut tilt) = (0.0_f32, 0.0_f32);
    for [here, there] in seams(&shape) {
        for step in 0..=8 {
            let t = step as f32 / 8.0;
            let (a, b) = (decoded(&map, here, t), decoded(&map, there, t));
            most = most.max(a.angle_between(b).to_degrees());
            tilt = tilt.max(a.angle_between(here[0].normal.lerp(here[1].normal, t)).to_degrees());
        }
    }
    assert!(most < 2.0, "sides differ by {most} degrees");
    assert!(tilt > 10.0, "the largest tilt is {tilt} degrees");
}

#[test]
fn the_file_is_whole_and_always_the_same() {
    let glb = super::model();
    assert!(glb == super::model());
    let word = |at: usize| u32::from_le_bytes([glb[at], glb[at + 1], glb[at + 2], glb[at + 3]]) as usize;
    assert_eq!((&glb[..4], word(4), word(8)), (&b"glTF"[..], 2, glb.len()));
    let json: serde_json::Value = serde_json::from_slice(&glb[20..20 + word(12)]).unwrap();
    let binary = &glb[20 + word(12) + 8..];
    for image in json["images"].as_array().unwrap() {
        let view = &json["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        assert_eq!(&binary[start..start + 8], b"\x89PNG\r\n\x1a\n");
    }
}
