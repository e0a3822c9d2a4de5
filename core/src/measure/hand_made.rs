//! Small finished conversions, made by hand: two triangles of a square, each in a block of its own, the
//! texels taken from a function of position.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3, Vec4};

use super::surface::{self, Surface};
use crate::asset::{Asset, Face, Material, Mesh, Primitive, Slot, TextureRef, UvTransform};
use crate::finished::{
    Anchor, Coordinates, Finished, FinishedPrimitive, FinishedTexture, FinishedTriangle, Frame, PrimitiveCuts,
};
use crate::image::{Image, Pixels, Transfer, Wrap};

/// Sides of 2^2 segments: levels 0 to 2 are exact.
pub const EXPONENT: usize = 2;

/// The unit square as triangles (0, 1, 2) and (3, 5, 4) of six vertices; they meet on the diagonal from
/// (1, 0) to (0, 1). Each has a chart of its own: the left and the right half of the image.
pub fn square(slot: Slot, image: Image) -> Asset {
    let mut material = Material { name: "Painted".to_owned(), normal_scale: 1.0, ..Material::default() };
    material.slots.insert(
        slot,
        TextureRef { image: 0, wrap: Wrap::default(), texcoord: 0, transform: UvTransform::default() },
    );
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
    let uvs = [(0.1, 0.2), (0.4, 0.2), (0.1, 0.8), (0.9, 0.2), (0.6, 0.8), (0.9, 0.8)];
    let primitive = Primitive {
        material: Some(0),
        positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
        texcoords: vec![uvs.map(|(u, v)| Vec2::new(u, v)).to_vec()],
        faces: vec![Face::triangle([0, 1, 2]), Face::triangle([3, 5, 4])],
        ..Primitive::default()
    };
    Asset {
        images: vec![image],
        materials: vec![material],
        meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
        ..Asset::default()
    }
}

/// The conversion of [`square`] whose texels hold `value` of their position, as 8-bit codes.
pub fn finished(slot: Slot, value: impl Fn(Vec3) -> [u8; 3]) -> Finished {
    finished_by_triangle(slot, |_, at| value(at))
}

/// The same, where each triangle has a function of its own, also beyond its diagonal.
pub fn finished_by_triangle(slot: Slot, value: impl Fn(usize, Vec3) -> [u8; 3]) -> Finished {
    let side = (1 << EXPONENT) as f32;
    let blocks = [Vec2::ZERO, Vec2::X * side];
    // The corners of both triangles in their block: the right angle first, the diagonal last.
    let corners = [Vec2::ZERO, Vec2::X * side, Vec2::Y * side];
    let triangle = |number: usize, vertices: [u32; 3]| FinishedTriangle {
        vertices,
        corners: corners.map(|corner| corner + blocks[number]),
        anchor: Anchor::Offset(Vec2::new(number as f32 + 0.5, 0.5)),
    };
    let triangles = vec![triangle(0, [0, 1, 2]), triangle(1, [5, 4, 3])];
    let positions = square(slot, image([1, 1], |_, _| [0; 3])).meshes[0].primitives[0].positions.clone();
    let levels = (0..=EXPONENT).map(|level| {
        let segments = 1u32 << (EXPONENT - level);
        image([2 * segments + 2, segments + 1], |x, y| {
            let number = usize::from(x > segments);
            let [a, b, c] = triangles[number].vertices.map(|vertex| positions[vertex as usize]);
            let at = Vec2::new((x - number as u32 * (segments + 1)) as f32, y as f32) / segments as f32;
            value(number, a + (b - a) * at.x + (c - a) * at.y)
        })
    });
    let levels = levels.collect();
    let transfer = if slot.is_color() { Transfer::Srgb } else { Transfer::Linear };
    Finished {
        textures: vec![FinishedTexture {
            materials: vec![0],
            part: 0,
            slots: vec![slot],
            transfer,
            levels,
            ranges: BTreeMap::new(),
            value_scale: None,
        }],
        primitives: vec![FinishedPrimitive {
            mesh: 0,
            primitive: 0,
            material: 0,
            part: 0,
            coordinates: Coordinates::Scaled,
            triangles,
            frames: Vec::new(),
            cuts: vec![PrimitiveCuts { texture: 0, bits: vec![0; 2] }],
        }],
        ..Finished::default()
    }
}

/// The surface of material 0 of a conversion.
pub fn surface_of<'a>(asset: &'a Asset, finished: &'a Finished) -> Surface<'a> {
    Surface::of_finished(asset, &surface::by_material(asset, finished)[0], 0).unwrap()
}

/// The surface of material 0 of a plain model.
pub fn source_surface(asset: &Asset) -> Surface<'_> {
    Surface::of_source(surface::of_source(asset).swap_remove(0), 0)
}

pub fn image(size: [u32; 2], value: impl Fn(u32, u32) -> [u8; 3]) -> Image {
    let codes = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).flat_map(|(x, y)| value(x, y));
    Image { width: size[0], height: size[1], components: 3, pixels: Pixels::U8(codes.collect()) }
}

/// A code of a level image.
pub fn code_mut(finished: &mut Finished, level: usize, [x, y]: [usize; 2], component: usize) -> &mut u8 {
    let image = &mut finished.textures[0].levels[level];
    let at = (y * image.width as usize + x) * 3 + component;
    match &mut image.pixels {
        Pixels::U8(codes) => &mut codes[at],
        Pixels::U16(_) | Pixels::F32(_) => panic!("made with 8 bits"),
    }
}

pub const UPRIGHT: Frame = Frame { normal: Vec3::Z, tangent: Vec4::new(1.0, 0.0, 0.0, 1.0) };
