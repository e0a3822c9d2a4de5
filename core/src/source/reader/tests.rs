use glam::{Vec2, Vec3, Vec4};

use super::FaceReader;
use crate::asset::{Asset, Attribute, Face, Material, Mesh, Primitive, Slot, TextureRef, UvTransform};
use crate::colors::Shape;
use crate::image::{Image, Pixels, Wrap};
use crate::mesh::{CanvasMesh, Polygons, build};
use crate::source::{SurfaceSource, channels};

/// A triangle and a bent quad with normals and tangents of all directions.
fn model(slot: Slot) -> (Asset, CanvasMesh) {
    let positions: Vec<Vec3> =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [0.0, 1.0, 0.1], [1.0, 1.0, 0.5], [0.4, 2.0, 0.0]]
            .map(Vec3::from)
            .to_vec();
    let faces = vec![Face::triangle([0, 1, 2]), Face { corners: [1, 3, 4, 2], count: 4 }];
    let tilt = |k: usize| Vec3::new((k as f32).sin(), (k as f32 * 2.0).cos(), 1.5).normalize();
    let primitive = Primitive {
        material: Some(0),
        texcoords: vec![
            positions.iter().map(|p| Vec2::new(p.x * 0.7 - 0.1 * p.y, p.y * 0.6 + p.z)).collect(),
        ],
        normals: (0..5).map(tilt).collect(),
        tangents: (0..5).map(|k| tilt(k).any_orthonormal_vector().extend(-1.0)).collect(),
        attributes: vec![colors()],
        positions,
        faces,
        ..Primitive::default()
    };
    let mut material = Material::default();
    material.slots.insert(
        slot,
        TextureRef { image: 0, wrap: Wrap::default(), texcoord: 0, transform: UvTransform::default() },
    );
    let pixels = (0..32 * 16 * 3u32).map(|k| (k * 97 % 200 + 28) as u8).collect();
    let mut asset = Asset {
        images: vec![Image { width: 32, height: 16, components: 3, pixels: Pixels::U8(pixels) }],
        materials: vec![material],
        ..Asset::default()
    };
    let mut faces = primitive.faces.iter().map(|face| (face.corners, face.count));
    let canvas =
        build([Polygons { mesh: 0, primitive: 0, positions: &primitive.positions, faces: &mut faces }]);
    drop(faces);
    asset.meshes.push(Mesh { name: String::new(), primitives: vec![primitive] });
    (asset, canvas)
}

/// Vertex colors of all kinds.
fn colors() -> Attribute {
    Attribute {
        semantic: "COLOR_0".to_owned(),
        component_type: 5121,
        kind: "VEC4".to_owned(),
        normalized: true,
        element_bytes: 4,
        bytes: (0..20u8).map(|k| k.wrapping_mul(89)).collect(),
    }
}

/// Rows show what single points show: with and without a tile, on both halves of a quad, colors, colors times vertex colors, and
/// normals.
#[test]
fn rows_agree_with_points() {
    for (slot, is_tinted) in [(Slot::BaseColor, false), (Slot::BaseColor, true), (Slot::Normal, true)] {
        let (asset, canvas) = model(slot);
        let channels = channels(&asset, 0, is_tinted);
        let source = SurfaceSource::new(&channels[0], &asset, &canvas);
        let wide = Shape::quad([8, 2]);
        let high = Shape::quad([2, 8]);
        let shapes = [(0, Shape::triangle(8)), (1, Shape::quad([8, 8])), (1, wide), (1, high)];
        for ((face, shape), fetch_count) in shapes.into_iter().flat_map(|shape| [(shape, 1000), (shape, 0)]) {
            let mut reader = FaceReader::default();
            let [n, m] = shape.segments;
            reader.open(&source, face, shape);
            reader.open_window(&source, [0, 0], [n, m], fetch_count);
            assert_eq!(reader.is_tiled, fetch_count > 0);
            for j in 0..m {
                let y = j as f32 + 0.25;
                let count = if face == 0 { (n - j) * 2 - 1 } else { 2 * n };
                let mut row = vec![Vec4::ZERO; count as usize];
                reader.row(&source, 0.125, y, 0.5, &mut row);
                for (k, found) in row.iter().enumerate() {
                    let x = 0.125 + 0.5 * k as f32;
                    let wanted = source.at(&canvas, face, x / n as f32, y / m as f32);
                    let worst = (*found - wanted).abs().max_element();
                    assert!(worst < 1e-4, "{slot:?} face {face} at {x} {y}: {found}, {wanted}");
                }
            }
        }
    }
}

/// At a corner the value is the texel's times the corner's color; without a texture it is the color.
#[test]
fn vertex_colors_multiply() {
    let (mut asset, canvas) = model(Slot::BaseColor);
    let colors = asset.meshes[0].primitives[0].vertex_colors().unwrap();
    let value = |asset: &Asset, takes: bool| {
        let channels = channels(asset, 0, takes);
        let source = SurfaceSource::new(&channels[0], asset, &canvas);
        // The quad's third corner is vertex 4, the middle of the triangle's first edge between 0 and 1.
        [source.at(&canvas, 1, 1.0, 1.0), source.along_edge(&canvas, 0, 0, 0.5)]
    };
    let ([plain, edge], tinted) = (value(&asset, false), value(&asset, true));
    let middle = (colors[0] + colors[1]) * 0.5;
    assert!((tinted[0] - plain * colors[4]).abs().max_element() < 1e-6);
    assert!((tinted[1] - edge * middle).abs().max_element() < 1e-6);
    asset.materials[0].slots = Default::default();
    assert!(channels(&asset, 0, false).is_empty());
    let alone = value(&asset, true);
    assert!((alone[0] - colors[4]).abs().max_element() < 1e-6);
    assert!((alone[1] - middle).abs().max_element() < 1e-6);
}
