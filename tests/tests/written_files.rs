//! Written files, judged by the Khronos validator: made-up conversions of real models, read, written and
//! read again.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};
use meshcolor::asset::Asset;
use meshcolor::finished::{
    Anchor, BlockClass, BlockTable, Coordinates, Finished, FinishedPrimitive, FinishedTexture,
    FinishedTriangle, Frame, PrimitiveCuts, TableLevel, extract,
};
use meshcolor::image::{Image, Pixels, Transfer};
use meshcolor::measure;
use meshcolor::read::{Limits, Upload, read};
use meshcolor::watch::Unwatched;
use meshcolor_tests::{models, validator};

const LEVEL_SIZES: [(u32, u32); 3] = [(64, 32), (33, 17), (18, 10)];

fn load(upload: &Upload) -> Asset {
    read(upload, &Limits::default(), &Unwatched).unwrap_or_else(|error| panic!("{}: {error}", upload.main))
}

/// Every textured slot of every material with faces, with coordinates and texels of no meaning.
fn made_up(asset: &Asset) -> Finished {
    let mut finished = Finished::default();
    for (material, source) in asset.materials.iter().enumerate() {
        for (number, &slot) in (0u8..).zip(source.slots.keys()) {
            let levels = LEVEL_SIZES.map(|(width, height)| gradient(width, height, number));
            let transfer = if slot.is_color() { Transfer::Srgb } else { Transfer::Linear };
            finished.textures.push(FinishedTexture {
                materials: vec![material],
                part: 0,
                slots: vec![slot],
                transfer,
                levels: levels.to_vec(),
                ranges: BTreeMap::new(),
                value_scale: None,
            });
        }
    }
    for (mesh, source) in asset.meshes.iter().enumerate() {
        for primitive in 0..source.primitives.len() {
            finished.primitives.extend(piece(asset, &finished.textures, mesh, primitive));
        }
    }
    finished
}

fn piece(
    asset: &Asset,
    textures: &[FinishedTexture],
    mesh: usize,
    primitive: usize,
) -> Option<FinishedPrimitive> {
    let source = &asset.meshes[mesh].primitives[primitive];
    let material = source.material?;
    let own = |texture: &FinishedTexture| texture.is_of(material, 0);
    let first = textures.iter().position(own).filter(|_| !source.faces.is_empty())?;
    let mut triangles = Vec::new();
    for (number, face) in source.faces.iter().enumerate() {
        for corners in face.triangles() {
            triangles.push(FinishedTriangle {
                vertices: corners.map(|corner| face.corners[corner]),
                corners: corners.map(|corner| Vec2::new(corner as f32, (number % 7) as f32)),
                anchor: Anchor::Offset(Vec2::new(0.5 + (number % 50) as f32, 1.5)),
            });
        }
    }
    let frame = Frame { normal: Vec3::Y, tangent: Vec4::new(0.6, 0.0, 0.8, -1.0) };
    let has_normals = textures.iter().any(|texture| own(texture) && texture.is_normal());
    let frames = if has_normals { vec![[frame; 3]; triangles.len()] } else { Vec::new() };
    let mut bits = vec![0; triangles.len()];
    bits[triangles.len() / 2] = 0b011;
    let cuts = vec![PrimitiveCuts { texture: first, bits }];
    let coordinates = Coordinates::Scaled;
    Some(FinishedPrimitive { mesh, primitive, material, part: 0, coordinates, triangles, frames, cuts })
}

fn gradient(width: u32, height: u32, shift: u8) -> Image {
    let code = |at: u32| (at as u8).wrapping_mul(3).wrapping_add(shift);
    let codes = (0..width * height * 3).map(code).collect();
    Image { width, height, components: 3, pixels: Pixels::U8(codes) }
}

/// The same with indexed coordinates: blocks of one quad, and of two side by side.
fn indexed(mut finished: Finished) -> Finished {
    let class =
        |columns: u32| BlockClass { exponents: [0, 0], cells: [columns, 1], gap: [1, 1], shift: [0, 0] };
    let level = |size: &(u32, u32)| TableLevel {
        columns: vec![size.0 / 2, size.0 / 3],
        firsts: vec![0; 2],
        origins: vec![[0, 0], [0, 4]],
    };
    let table =
        BlockTable { classes: vec![class(1), class(2)], levels: LEVEL_SIZES.iter().map(level).collect() };
    let table = Arc::new(table);
    for piece in &mut finished.primitives {
        piece.coordinates = Coordinates::Indexed(Arc::clone(&table));
        for (number, triangle) in piece.triangles.iter_mut().enumerate() {
            let (class, number) = (number as u32 % 2, number as u32 / 2 % 12);
            triangle.corners = [0, 1, 2].map(|k: u32| Vec2::new((k % 2 + class) as f32, (k / 2) as f32));
            triangle.anchor = Anchor::Block { class, number };
        }
    }
    finished
}

/// Writes made-up conversions, has them judged, and reads them back: what comes back is what went in, with
/// the vertices numbered anew.
fn judge(name: &str, upload: &Upload) {
    let asset = load(upload);
    let finished = made_up(&asset);
    assert!(!finished.primitives.is_empty(), "{name} has nothing to convert");
    judge_one(name, &asset, &finished);
    judge_one(&format!("{name}, indexed"), &asset, &indexed(finished.clone()));
    judge_parts(&format!("{name}, in parts"), &asset, &in_parts(finished));
}

/// Every other face in a second part, with images of its own.
fn in_parts(whole: Finished) -> Finished {
    let second = |texture: &FinishedTexture| FinishedTexture { part: 1, ..texture.clone() };
    let (first, second) = (whole.textures.clone(), whole.textures.iter().map(second));
    let count = whole.textures.len();
    let mut finished =
        Finished { textures: first.into_iter().chain(second).collect(), ..Finished::default() };
    finished.textures.sort_by_key(|texture| (texture.materials[0], texture.part));
    let number = |old: usize, part: usize| {
        let FinishedTexture { materials, slots, .. } = &whole.textures[old];
        let mut own = finished.textures_of(materials[0], part);
        own.find(|(_, texture)| texture.slots == *slots).expect("it was made above").0
    };
    assert_eq!(finished.textures.len(), 2 * count);
    let mut primitives = Vec::new();
    for piece in &whole.primitives {
        for part in 0..2 {
            let is_here = |triangle: &usize| triangle / 2 % 2 == part;
            let numbers: Vec<usize> = (0..piece.triangles.len()).filter(is_here).collect();
            if numbers.is_empty() {
                continue;
            }
            let cuts = piece.cuts.iter().map(|cuts| PrimitiveCuts {
                texture: number(cuts.texture, part),
                bits: numbers.iter().map(|&triangle| cuts.bits[triangle]).collect(),
            });
            let is_framed = !piece.frames.is_empty();
            primitives.push(FinishedPrimitive {
                part,
                triangles: numbers.iter().map(|&number| piece.triangles[number]).collect(),
                frames: numbers.iter().filter(|_| is_framed).map(|&number| piece.frames[number]).collect(),
                cuts: cuts.collect(),
                ..piece.clone()
            });
        }
    }
    finished.primitives = primitives;
    finished
}

fn judge_parts(name: &str, asset: &Asset, finished: &Finished) {
    let glb = meshcolor::write::glb(asset, finished, &Unwatched).unwrap().bytes;
    validator::expect_valid(name, &glb, true);
    let back = load(&Upload::single("asset.glb", glb));
    let read = extract(&back).unwrap().unwrap();
    assert!(read.textures == finished.textures, "{name}: other textures");
    // Primitives of further parts stand behind all others of their mesh.
    let sorted = |asset: &Asset, finished: &Finished| {
        let mut triangles: Vec<_> = Vec::new();
        for piece in &finished.primitives {
            let positions = &asset.meshes[piece.mesh].primitives[piece.primitive].positions;
            for triangle in &piece.triangles {
                let at =
                    triangle.vertices.map(|vertex| positions[vertex as usize].to_array().map(f32::to_bits));
                let corners = triangle.corners.map(|corner| corner.to_array().map(f32::to_bits));
                triangles.push((piece.mesh, piece.material, piece.part, at, corners));
            }
        }
        triangles.sort_unstable();
        triangles
    };
    assert!(sorted(&back, &read) == sorted(asset, finished), "{name}: other triangles");
    measure::converted_file(&back, &read, &Unwatched).unwrap_or_else(|error| panic!("{name}: {error}"));
}

/// The model's first mesh with every primitive once more, of a material that is another by name alone, or also by
/// `changed`.
fn doubled(mut asset: Asset, changed: bool) -> (Asset, Finished) {
    let mut finished = made_up(&asset);
    let materials = asset.document.json["materials"].as_array_mut().expect("it has materials");
    let count = materials.len();
    for number in 0..count {
        let mut again = materials[number].clone();
        again["name"] = format!("again {number}").into();
        if changed {
            again["alphaMode"] = "BLEND".into();
        }
        materials.push(again);
    }
    asset.materials.extend_from_within(..);
    let json = asset.document.json["meshes"][0]["primitives"].as_array_mut().expect("it has primitives");
    let primitives = &mut asset.meshes[0].primitives;
    let first = primitives.len();
    json.extend_from_within(..);
    primitives.extend_from_within(..);
    for (json, primitive) in json.iter_mut().zip(&mut *primitives).skip(first) {
        primitive.material = primitive.material.map(|material| material + count);
        json["material"] = primitive.material.into();
    }
    for texture in &mut finished.textures {
        texture.materials.push(texture.materials[0] + count);
    }
    let own = finished.primitives.iter().filter(|piece| piece.mesh == 0).cloned();
    let again: Vec<_> = own
        .map(|piece| FinishedPrimitive {
            primitive: piece.primitive + first,
            material: piece.material + count,
            ..piece
        })
        .collect();
    finished.primitives.extend(again);
    finished.primitives.sort_by_key(|piece| (piece.mesh, piece.primitive, piece.part));
    (asset, finished)
}

#[test]
fn merged_materials_are_valid_and_drawn_at_once() {
    for (name, upload) in ["DamagedHelmet", "Fox"].map(|name| (name, models::upload(name))) {
        let Some(upload) = upload else { continue };
        for changed in [false, true] {
            let (asset, finished) = doubled(load(&upload), changed);
            let glb = meshcolor::write::glb(&asset, &finished, &Unwatched).unwrap().bytes;
            validator::expect_valid(&format!("{name}, twice"), &glb, true);
            let back = load(&Upload::single("asset.glb", glb));
            let read = extract(&back).unwrap().unwrap();
            let count = finished.primitives.len();
            assert_eq!(read.primitives.len(), if changed { count } else { count / 2 }, "{name}");
            assert_eq!(read.textures.len(), finished.textures.len(), "{name}");
            let triangles = |finished: &Finished| {
                finished.primitives.iter().map(|piece| piece.triangles.len()).sum::<usize>()
            };
            assert_eq!(triangles(&read), triangles(&finished), "{name}");
        }
    }
}

fn judge_one(name: &str, asset: &Asset, finished: &Finished) {
    let glb = meshcolor::write::glb(asset, finished, &Unwatched).unwrap().bytes;
    validator::expect_valid(name, &glb, true);

    let back = load(&Upload::single("asset.glb", glb));
    let read = extract(&back).unwrap().unwrap();
    assert_eq!(read.textures, finished.textures, "{name}");
    assert_eq!(read.primitives.len(), finished.primitives.len(), "{name}");
    for (read, wrote) in read.primitives.iter().zip(&finished.primitives) {
        assert_eq!((read.mesh, read.primitive, &read.cuts), (wrote.mesh, wrote.primitive, &wrote.cuts));
        assert!(read.frames == wrote.frames, "{name}: frames");
        assert_eq!(read.coordinates, wrote.coordinates, "{name}");
        let positions = |asset: &Asset, piece: &FinishedPrimitive| -> Vec<Vec3> {
            let source = &asset.meshes[piece.mesh].primitives[piece.primitive];
            let vertices = piece.triangles.iter().flat_map(|triangle| triangle.vertices);
            vertices.map(|vertex| source.positions[vertex as usize]).collect()
        };
        assert!(positions(&back, read) == positions(asset, wrote), "{name}: positions");
        let places = |piece: &FinishedPrimitive| -> Vec<_> {
            piece.triangles.iter().map(|triangle| (triangle.corners, triangle.anchor)).collect()
        };
        assert!(places(read) == places(wrote), "{name}: places");
    }
    let passed_on = |asset: &Asset| (asset.instances.clone(), asset.document.json["animations"].is_null());
    assert_eq!(passed_on(&back), passed_on(asset), "{name}");
}

#[test]
fn real_models_are_valid_and_come_back() {
    for name in ["DamagedHelmet", "Fox", "spot"] {
        if let Some(upload) = models::upload(name) {
            judge(name, &upload);
        }
    }
}

#[test]
fn the_demo_model_is_valid_before_and_after() {
    let sample = meshcolor_service::sample::model();
    validator::expect_valid("the sample", &sample, true);
    judge("the sample, converted", &Upload::single("sample.glb", sample));
}

#[test]
fn a_model_without_anything_converted_passes_through() {
    for name in ["DamagedHelmet.glb", "Fox.glb"] {
        let Some(bytes) = models::bytes(name) else { return };
        let asset = load(&Upload::single(name, bytes));
        let glb = meshcolor::write::glb(&asset, &Finished::default(), &Unwatched).unwrap().bytes;
        // The source has warnings of its own.
        validator::expect_valid(name, &glb, false);
        let back = load(&Upload::single(name, glb));
        assert!(extract(&back).unwrap().is_none());
        assert_eq!(format!("{:?}", back.meshes), format!("{:?}", asset.meshes), "{name}");
        assert_eq!(back.images, asset.images, "{name}");
    }
}

#[test]
fn an_obj_model_without_anything_converted_is_valid() {
    let Some(bytes) = models::bytes("monsterfrog.obj") else { return };
    let asset = load(&Upload::single("monsterfrog.obj", bytes));
    let glb = meshcolor::write::glb(&asset, &Finished::default(), &Unwatched).unwrap().bytes;
    validator::expect_valid("monsterfrog", &glb, true);
    let triangle_count = |asset: &Asset| -> usize {
        let primitives = asset.meshes.iter().flat_map(|mesh| &mesh.primitives);
        primitives.flat_map(|primitive| &primitive.faces).map(|face| face.triangles().len()).sum()
    };
    assert_eq!(triangle_count(&load(&Upload::single("frog.glb", glb))), triangle_count(&asset));
}
