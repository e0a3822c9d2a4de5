//! A model made by hand with both of its forms: a ball of six patches, each an island of a UV atlas turned
//! at an odd angle, and the same patches as blocks of mesh color textures. Colors and normals are functions
//! of the place on the ball, so the converted form is seamless by construction and the source is not.

use std::collections::BTreeMap;

use glam::{Affine3A, Mat2, Vec2, Vec3, Vec4};
use meshcolor::asset::{
    AlphaMode, Asset, Face, Instance, Material, Mesh, Primitive, Slot, TextureRef, UvTransform,
};
use meshcolor::finished::{
    Anchor, BlockClass, BlockTable, Coordinates, Finished, FinishedPrimitive, FinishedTexture,
    FinishedTriangle, Frame, TableLevel,
};
use meshcolor::image::{Image, Pixels, Transfer, Wrap, WrapMode};
use meshcolor::math::transfer::linear_to_srgb;
use meshcolor::measure::{Growth, Report, SubjectKind, Verdict};
use meshcolor::pipeline::{Conversion, Focus};

/// Quads along the side of a patch.
const QUADS: usize = 6;
/// Resolution exponent of every quad.
const EXPONENT: usize = 5;
const ATLAS: u32 = 1024;
/// Half the side of an island, texels.
const ISLAND: f32 = 118.0;

/// The three directions of a patch: right, up, out.
fn axes(patch: usize) -> [Vec3; 3] {
    let out = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z][patch];
    let right = if out.x.abs() > 0.5 { Vec3::NEG_Z * out.x } else { Vec3::X };
    [right, out.cross(right), out]
}

/// A place on the ball; `at` in [-1, 1]² on the patch.
fn place(patch: usize, at: Vec2) -> Vec3 {
    let [right, up, out] = axes(patch);
    (out + right * at.x + up * at.y).normalize()
}

/// A place on the ball, in the unit square of one of its quads.
pub fn on_ball(quad: usize, at: Vec2) -> Vec3 {
    place(quad / (QUADS * QUADS), quad_corner(quad % (QUADS * QUADS)) + at * 2.0 / QUADS as f32)
}

/// Linear color, with waves shorter than `blur` faded out.
pub fn color(p: Vec3, blur: f32) -> Vec3 {
    let wave = |direction: Vec3, pitch: f32| {
        (p.dot(direction.normalize()) * pitch).sin() * (-(pitch * blur) * (pitch * blur)).exp()
    };
    let coarse = wave(Vec3::new(1.0, 0.7, -0.4), 5.0) + 0.7 * wave(Vec3::new(-0.3, 1.0, 0.8), 7.0);
    let fine = wave(Vec3::new(0.2, -0.9, 1.0), 31.0) + wave(Vec3::new(1.0, 0.1, 0.7), 43.0);
    let warm = Vec3::new(0.62, 0.24, 0.10);
    let cool = Vec3::new(0.06, 0.22, 0.36);
    (cool.lerp(warm, 0.5 + 0.28 * coarse) * (1.0 + 0.35 * fine)).clamp(Vec3::splat(0.01), Vec3::splat(0.95))
}

pub fn object_normal(p: Vec3) -> Vec3 {
    let dent = Vec3::new((p.y * 17.0).sin(), (p.z * 19.0).sin(), (p.x * 23.0).sin()) * 0.16;
    (p + dent - p * dent.dot(p)).normalize()
}

fn frame(patch: usize, p: Vec3) -> Frame {
    let right = axes(patch)[0];
    Frame { normal: p, tangent: (right - p * right.dot(p)).normalize().extend(1.0) }
}

/// What a tangent-space normal map stores for `direction`.
fn encoded_normal(direction: Vec3, frame: Frame) -> Vec3 {
    let tangent = frame.tangent.truncate();
    let bitangent = frame.normal.cross(tangent) * frame.tangent.w;
    0.5 + 0.5 * Vec3::new(direction.dot(tangent), direction.dot(bitangent), direction.dot(frame.normal))
}

fn codes(values: &[Vec3], transfer: Transfer) -> Vec<u8> {
    let code = |value: f32| match transfer {
        Transfer::Srgb => linear_to_srgb(value) * 255.0 + 0.5,
        Transfer::Linear => value * 255.0 + 0.5,
    };
    values.iter().flat_map(|value| value.to_array().map(|v| code(v) as u8)).collect()
}

fn picture(size: [u32; 2], values: &[Vec3], transfer: Transfer) -> Image {
    Image { width: size[0], height: size[1], components: 3, pixels: Pixels::U8(codes(values, transfer)) }
}

fn island_turn(patch: usize) -> Mat2 {
    Mat2::from_angle(0.3 + 0.77 * patch as f32)
}

fn island_middle(patch: usize) -> Vec2 {
    Vec2::new(170.0 + 341.0 * (patch % 3) as f32, 256.0 + 512.0 * (patch / 3) as f32)
}

/// Texel of the atlas to place on a patch.
fn from_atlas(patch: usize, texel: Vec2) -> Vec2 {
    island_turn(patch).transpose() * (texel - island_middle(patch)) / ISLAND
}

fn to_atlas(patch: usize, at: Vec2) -> Vec2 {
    (island_middle(patch) + island_turn(patch) * at * ISLAND) / ATLAS as f32
}

/// The atlas, each island four texels larger than it is used.
fn atlas(transfer: Transfer, background: Vec3, value: impl Fn(usize, Vec2) -> Vec3) -> Image {
    let side = ATLAS as usize;
    let mut values = vec![background; side * side];
    for (texel, out) in values.iter_mut().enumerate() {
        let center = Vec2::new((texel % side) as f32, (texel / side) as f32) + 0.5;
        let patch = (texel % side * 3 / side) + 3 * (texel / side * 2 / side);
        let at = from_atlas(patch, center);
        if at.abs().max_element() < 1.0 + 4.0 / ISLAND {
            *out = value(patch, at);
        }
    }
    picture([ATLAS, ATLAS], &values, transfer)
}

const BLOCK_COLUMNS: usize = 15;

/// A level of a mesh color texture: 6 patches of 36 blocks, 15 in a row.
fn level_image(level: usize, transfer: Transfer, value: impl Fn(usize, Vec2) -> Vec3) -> Image {
    let segments = 1 << (EXPONENT - level);
    let block_count = 6 * QUADS * QUADS;
    let width = BLOCK_COLUMNS * (segments + 1);
    let height = block_count.div_ceil(BLOCK_COLUMNS) * (segments + 1);
    let mut values = vec![Vec3::ZERO; width * height];
    for block in 0..block_count {
        let (patch, quad) = (block / (QUADS * QUADS), block % (QUADS * QUADS));
        let origin = [block % BLOCK_COLUMNS, block / BLOCK_COLUMNS].map(|n| n * (segments + 1));
        for y in 0..=segments {
            for x in 0..=segments {
                let inner = Vec2::new(x as f32, y as f32) / segments as f32;
                let at = quad_corner(quad) + inner * 2.0 / QUADS as f32;
                values[(origin[1] + y) * width + origin[0] + x] = value(patch, at);
            }
        }
    }
    picture([width as u32, height as u32], &values, transfer)
}

fn quad_corner(quad: usize) -> Vec2 {
    Vec2::new((quad % QUADS) as f32, (quad / QUADS) as f32) * 2.0 / QUADS as f32 - 1.0
}

fn reference(image: usize) -> Option<TextureRef> {
    Some(TextureRef { image, wrap: Wrap::default(), texcoord: 0, transform: UvTransform::default() })
}

fn material() -> Material {
    let mut material = Material {
        name: "glaze".to_owned(),
        base_color_factor: Vec4::ONE,
        metallic_factor: 0.0,
        roughness_factor: 0.45,
        normal_scale: 1.0,
        occlusion_strength: 1.0,
        ..Material::default()
    };
    material.slots.extend(reference(0).map(|texture| (Slot::BaseColor, texture)));
    material.slots.extend(reference(1).map(|texture| (Slot::Normal, texture)));
    material
}

fn primitives() -> (Primitive, FinishedPrimitive) {
    let mut source = Primitive { material: Some(0), texcoords: vec![vec![]], ..Primitive::default() };
    let (mut triangles, mut frames) = (vec![], vec![]);
    let segments = (1 << EXPONENT) as f32;
    for block in 0..6 * QUADS * QUADS {
        let (patch, quad) = (block / (QUADS * QUADS), block % (QUADS * QUADS));
        let first = source.positions.len() as u32;
        let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        for corner in corners {
            let at = quad_corner(quad) + corner * 2.0 / QUADS as f32;
            let frame = frame(patch, place(patch, at));
            source.positions.push(frame.normal);
            source.normals.push(frame.normal);
            source.tangents.push(frame.tangent);
            source.texcoords[0].push(to_atlas(patch, at));
        }
        source.faces.push(Face::quad(std::array::from_fn(|corner| first + corner as u32)));
        let block_at = Vec2::new((block % BLOCK_COLUMNS) as f32, (block / BLOCK_COLUMNS) as f32);
        for piece in [[0, 1, 2], [0, 2, 3]] {
            triangles.push(FinishedTriangle {
                vertices: piece.map(|corner| first + corner as u32),
                corners: piece.map(|corner| (block_at + corners[corner]) * segments),
                anchor: Anchor::Offset(block_at + 0.5),
            });
            frames.push(piece.map(|corner| Frame {
                normal: source.normals[first as usize + corner],
                tangent: source.tangents[first as usize + corner],
            }));
        }
    }
    let coordinates = Coordinates::Scaled;
    let (mesh, primitive, material, cuts) = (0, 0, 0, vec![]);
    let finished =
        FinishedPrimitive { mesh, primitive, material, part: 0, coordinates, triangles, frames, cuts };
    (source, finished)
}

fn focus() -> Focus {
    // The middle of the edge between the patches +z and +x.
    let ends = [place(4, Vec2::new(1.0, 0.0)), place(4, Vec2::new(1.0, 2.0 / QUADS as f32))];
    let position = (ends[0] + ends[1]) / 2.0;
    let source_jumps_codes = [0.1, 0.4, 1.3, 3.9, 9.0, 17.0, 24.0, 31.0];
    let normal = position.normalize();
    Focus { mesh: 0, primitive: 0, position, ends, normal, texture: 0, source_jumps_codes }
}

fn report() -> Report {
    Report {
        kind: SubjectKind::Converted,
        engine_version: String::new(),
        verdict: Verdict::Pass,
        errors: vec![],
        warnings: vec![],
        max_seam_delta_codes: 0.0,
        options: serde_json::Map::new(),
        channels: vec![],
        layouts: vec![],
        growth: Growth::default(),
        effects: vec![],
        compression: Vec::new(),
        mesh_colors: Vec::new(),
    }
}

/// The ball, base color and normal map, six levels, two instances.
pub fn ball() -> Conversion {
    let normal_value = |patch: usize, at: Vec2| {
        let p = place(patch, at);
        encoded_normal(object_normal(p), frame(patch, p))
    };
    let gray = Vec3::splat(0.2);
    let (primitive, finished_primitive) = primitives();
    let asset = Asset {
        images: vec![
            atlas(Transfer::Srgb, gray, |patch, at| color(place(patch, at), 0.0)),
            atlas(Transfer::Linear, Vec3::new(0.5, 0.5, 1.0), normal_value),
        ],
        materials: vec![material()],
        meshes: vec![Mesh { name: "ball".to_owned(), primitives: vec![primitive] }],
        instances: vec![
            Instance { mesh: 0, transform: Affine3A::IDENTITY },
            Instance {
                mesh: 0,
                // Mirrored, smaller, behind.
                transform: Affine3A::from_scale_rotation_translation(
                    Vec3::new(-0.5, 0.5, 0.5),
                    glam::Quat::from_rotation_y(0.6),
                    Vec3::new(1.3, -0.5, 0.3),
                ),
            },
        ],
        ..Asset::default()
    };
    let base = (0..=EXPONENT).map(|level| {
        // A box of 2^level texels of the atlas, as a Gaussian of the same spread.
        let blur = if level == 0 { 0.0 } else { 0.0018 * (1 << level) as f32 };
        level_image(level, Transfer::Srgb, |patch, at| color(place(patch, at), blur))
    });
    let normal = (0..=EXPONENT).map(|level| level_image(level, Transfer::Linear, normal_value));
    let texture = |slot, transfer, levels| FinishedTexture {
        materials: vec![0],
        part: 0,
        slots: vec![slot],
        transfer,
        levels,
        ranges: BTreeMap::new(),
        value_scale: None,
    };
    let finished = Finished {
        textures: vec![
            texture(Slot::BaseColor, Transfer::Srgb, base.collect()),
            texture(Slot::Normal, Transfer::Linear, normal.collect()),
        ],
        primitives: vec![finished_primitive],
        ..Finished::default()
    };
    Conversion { asset, finished, report: report(), files: vec![], focus: Some(focus()) }
}

/// The ball with indexed coordinates: the same images and places.
pub fn indexed_ball() -> Conversion {
    let mut conversion = ball();
    let piece = &mut conversion.finished.primitives[0];
    let exponents = [EXPONENT as u8; 2];
    let shape = BlockClass { exponents, cells: [1, 1], gap: [1, 1], shift: [0, 0] };
    // Another class stands before it, which nothing uses.
    let level =
        TableLevel { columns: vec![1, BLOCK_COLUMNS as u32], firsts: vec![0; 2], origins: vec![[0, 0]; 2] };
    let table = BlockTable { classes: vec![shape, shape], levels: vec![level; EXPONENT + 1] };
    piece.coordinates = Coordinates::Indexed(table.into());
    for (number, triangle) in piece.triangles.iter_mut().enumerate() {
        let [x, y] = [number / 2 % BLOCK_COLUMNS, number / 2 / BLOCK_COLUMNS].map(|n| n as f32);
        let segments = (1 << EXPONENT) as f32;
        triangle.corners = triangle.corners.map(|corner| corner / segments - Vec2::new(x, y));
        triangle.anchor = Anchor::Block { class: 1, number: (number / 2) as u32 };
    }
    conversion
}

/// Gives the ball all five slots, alpha, a second texture coordinate set, wrapping, a transform, 16-bit
/// texels, two sides, and one primitive whose normals and tangents must be made up.
pub fn enrich(conversion: &mut Conversion, alpha_mode: AlphaMode) {
    let asset = &mut conversion.asset;
    let side = 64;
    let rough = (0..side * side).flat_map(|i| {
        let (x, y) = (i % side, i / side);
        [(x * 9 + y) as u8, (x * 3) as u8, (255 - y * 3) as u8]
    });
    let rough = Image { width: side, height: side, components: 3, pixels: Pixels::U8(rough.collect()) };
    let glow: Vec<u16> = (0..32 * 16).flat_map(|i| [(i * 100) as u16, 65_535 - (i * 64) as u16]).collect();
    let glow = Image { width: 32, height: 16, components: 2, pixels: Pixels::U16(glow) };
    asset.images.extend([rough, glow]);
    let wrap = Wrap { s: WrapMode::MirroredRepeat, t: WrapMode::ClampToEdge };
    let transform = UvTransform { offset: Vec2::new(0.1, 0.2), rotation: 0.5, scale: Vec2::new(2.0, 1.5) };
    let second = |image| TextureRef { image, wrap, texcoord: 1, transform };
    let material = &mut asset.materials[0];
    material.slots.insert(Slot::MetallicRoughness, second(2));
    material.slots.insert(Slot::Occlusion, second(2));
    material.slots.insert(Slot::Emissive, second(3));
    material.emissive_factor = Vec3::new(0.1, 0.05, 0.02);
    material.metallic_factor = 0.8;
    material.roughness_factor = 0.9;
    material.base_color_factor = Vec4::new(0.9, 1.0, 0.8, 0.7);
    material.alpha_mode = alpha_mode;
    material.double_sided = true;
    let primitive = &mut asset.meshes[0].primitives[0];
    let second_set = primitive.positions.iter().map(|p| Vec2::new(p.x + p.z, p.y) * 0.6).collect();
    primitive.texcoords.push(second_set);
    // The same ball once more, below, as plain geometry of a material without conversion.
    let mut plain = primitive.clone();
    plain.normals.clear();
    plain.tangents.clear();
    plain.material = Some(1);
    for position in &mut plain.positions {
        *position = *position * 0.4 + Vec3::new(0.0, -1.5, 0.0);
    }
    asset.meshes[0].primitives.push(plain);
    let mut unconverted = asset.materials[0].clone();
    unconverted.alpha_mode = AlphaMode::Opaque;
    asset.materials.push(unconverted);
}
