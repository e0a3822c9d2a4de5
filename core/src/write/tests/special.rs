//! Sources that need more than a new texture: made-up documents, variants, missing sets, image files.

use glam::{Vec2, Vec3};
use serde_json::json;

use super::{fixture, parse};
use crate::asset::{Asset, Document, EncodedImage, Face, Material, Mesh, Primitive};
use crate::finished::{Anchor, Coordinates, Finished, FinishedPrimitive, FinishedTriangle, extract};
use crate::watch::Unwatched;
use crate::write::glb;

/// Two primitives of one mesh, as they come from a text format: no accessors, a quad and a triangle.
pub fn made_up_document() -> Asset {
    let primitive = |material| Primitive {
        material: Some(material),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y, Vec3::new(0.5, 2.0, 0.0)],
        texcoords: vec![vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y, Vec2::new(0.5, 1.0)]],
        faces: vec![Face::quad([0, 1, 2, 3]), Face::triangle([3, 2, 4])],
        ..Primitive::default()
    };
    let primitives = json!([{ "material": 0 }, { "material": 1 }]);
    let texture =
        |index: usize| json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": index } } });
    let json = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": primitives }],
        "materials": [texture(0), texture(1)],
        "textures": [{ "source": 0 }, { "source": 1 }],
        "images": [{ "name": "a" }, { "name": "b", "uri": "b.png" }],
    });
    let image = fixture::noise(4, 4, 3, 1);
    let file = EncodedImage { media_type: "image/png".into(), bytes: crate::write::png(&image).unwrap() };
    Asset {
        document: Document { json, buffers: Vec::new(), encoded_images: vec![file.clone(), file] },
        images: vec![image.clone(), image],
        materials: vec![Material::default(), Material::default()],
        meshes: vec![Mesh { name: String::new(), primitives: vec![primitive(0), primitive(1)] }],
        ..Asset::default()
    }
}

pub fn finished(asset: &Asset) -> Finished {
    let mut finished = fixture::finished(&parse::asset(&fixture::source_glb()));
    finished.textures.truncate(1);
    let source = &asset.meshes[0].primitives[0];
    let triangles = source.faces.iter().enumerate().flat_map(|(number, face)| {
        face.triangles().iter().map(move |corners| FinishedTriangle {
            vertices: corners.map(|corner| face.corners[corner]),
            corners: corners.map(|corner| Vec2::splat(corner as f32)),
            anchor: Anchor::Offset(Vec2::splat(0.5 + number as f32)),
        })
    });
    finished.primitives = vec![FinishedPrimitive {
        mesh: 0,
        primitive: 0,
        material: 0,
        part: 0,
        coordinates: Coordinates::Scaled,
        triangles: triangles.collect(),
        frames: Vec::new(),
        cuts: Vec::new(),
    }];
    finished
}

#[test]
fn a_made_up_document_gets_all_its_data() {
    let asset = made_up_document();
    let finished = finished(&asset);
    let back = parse::asset(&glb(&asset, &finished, &Unwatched).unwrap().bytes);
    let read = extract(&back).unwrap().unwrap();
    assert_eq!(read.textures, finished.textures);
    // The quad is two triangles at one place, so its four corners stay four vertices; the triangle has
    // another offset and so three of its own.
    assert_eq!(
        (back.meshes[0].primitives[0].faces.len(), back.meshes[0].primitives[0].positions.len()),
        (3, 7)
    );
    let plain = &back.meshes[0].primitives[1];
    let source = &asset.meshes[0].primitives[1];
    assert_eq!((&plain.positions, &plain.texcoords), (&source.positions, &source.texcoords));
    let corners: Vec<_> = plain.faces.iter().map(|face| face.corners().to_vec()).collect();
    assert_eq!(corners, [[0, 1, 2], [0, 2, 3], [3, 2, 4]]);
    // The image that is not converted is in the file; the one that is, is not.
    let names: Vec<_> = back.document.json["images"].as_array().unwrap().iter().map(|i| &i["name"]).collect();
    assert_eq!(names[0], "b");
    assert_eq!(names.len(), 1 + 3);
    assert!(back.document.json["images"][0].get("uri").is_none());
    assert_eq!(back.images[0], asset.images[1]);
}

#[test]
fn a_primitive_without_data_is_refused() {
    let mut asset = made_up_document();
    asset.meshes[0].primitives[1] = Primitive::default();
    let error = glb(&asset, &finished(&asset), &Unwatched).unwrap_err();
    assert_eq!(error.pointer.as_deref(), Some("/meshes/0/primitives/1"));
}

#[test]
fn a_triangle_beyond_its_vertices_is_refused() {
    let asset = made_up_document();
    let mut finished = finished(&asset);
    finished.primitives[0].triangles[1].vertices[2] = 99;
    assert_eq!(glb(&asset, &finished, &Unwatched).unwrap_err().code, crate::ErrorCode::Internal);
}

#[test]
fn a_set_that_the_primitive_lacks_is_written_as_zeros() {
    let mut asset = made_up_document();
    asset.document.json["materials"][0]["emissiveTexture"] = json!({ "index": 1, "texCoord": 3 });
    let back = parse::asset(&glb(&asset, &finished(&asset), &Unwatched).unwrap().bytes);
    assert_eq!(back.document.json["materials"][0]["emissiveTexture"]["texCoord"], 1);
    assert_eq!(back.meshes[0].primitives[0].texcoords[1], vec![Vec2::ZERO; 7]);
}

#[test]
fn texture_transforms_that_stay_read_the_moved_set() {
    let mut asset = made_up_document();
    asset.document.json["extensionsUsed"] = json!(["KHR_texture_transform"]);
    asset.document.json["extensionsRequired"] = json!(["KHR_texture_transform"]);
    let transform = json!({ "KHR_texture_transform": { "texCoord": 2, "scale": [3.0, 3.0] } });
    asset.document.json["materials"][0]["emissiveTexture"] =
        json!({ "index": 1, "texCoord": 0, "extensions": transform });
    let (json, _) = parse::split(&glb(&asset, &finished(&asset), &Unwatched).unwrap().bytes);
    let emissive = &json["materials"][0]["emissiveTexture"];
    let moved = &emissive["extensions"]["KHR_texture_transform"];
    assert_eq!((&emissive["texCoord"], &moved["texCoord"]), (&1.into(), &2.into()));
    assert_eq!(moved["scale"], json!([3.0, 3.0]));
    assert_eq!(json["extensionsRequired"], json!(["KHR_texture_transform"]));
}

#[test]
fn variants_of_a_converted_primitive_read_the_moved_set() {
    let mut asset = made_up_document();
    let mapping = |material: usize| json!({ "material": material, "variants": [material] });
    asset.document.json["extensionsUsed"] = json!(["KHR_materials_variants"]);
    asset.document.json["extensions"] =
        json!({ "KHR_materials_variants": { "variants": [{ "name": "a" }, { "name": "b" }] } });
    for primitive in 0..2 {
        asset.document.json["meshes"][0]["primitives"][primitive]["extensions"] =
            json!({ "KHR_materials_variants": { "mappings": [mapping(0), mapping(1)] } });
    }
    let (json, bin) = parse::split(&glb(&asset, &finished(&asset), &Unwatched).unwrap().bytes);
    let mapped = |primitive: usize| {
        let primitive = &json["meshes"][0]["primitives"][primitive];
        let mappings = &primitive["extensions"]["KHR_materials_variants"]["mappings"];
        [&primitive["material"], &mappings[0]["material"], &mappings[1]["material"]]
            .map(|m| m.as_u64().unwrap())
    };
    let base =
        |material: u64| &json["materials"][material as usize]["pbrMetallicRoughness"]["baseColorTexture"];
    // The converted one: its own material, and a copy of the other that reads the set behind.
    let [own, first, second] = mapped(0);
    assert_eq!((own, first), (0, 0));
    assert_eq!((second, &base(second)["texCoord"]), (2, &1.into()));
    // The plain one: its own material, and a copy of the converted one as it was.
    let [own, first, second] = mapped(1);
    assert_eq!((own, second), (1, 1));
    assert_eq!((first, base(first).get("texCoord")), (3, None));
    let source =
        json["textures"][base(first)["index"].as_u64().unwrap() as usize]["source"].as_u64().unwrap();
    assert_eq!(json["images"][source as usize]["name"], "a");
    let attributes = &json["meshes"][0]["primitives"][0]["attributes"];
    let second_set = attributes["TEXCOORD_1"].as_u64().unwrap() as usize;
    assert_eq!(parse::attribute(&json, &bin, "", second_set).kind, "VEC2");
}
