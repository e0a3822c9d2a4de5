//! Slots, samplers, transforms and factors of glTF materials.

use glam::{Vec2, Vec3, Vec4};

use super::*;
use crate::asset::{AlphaMode, Material, Slot, TextureRef, UvTransform};
use crate::image::{Wrap, WrapMode};

fn materials(gltf: &Gltf) -> Vec<Material> {
    gltf.read().unwrap().materials
}

#[test]
fn defaults_are_those_of_the_specification() {
    let mut gltf = Gltf::triangle();
    gltf.json["materials"] = json!([{}, { "alphaMode": "MASK" }]);
    let read = materials(&gltf);
    let material = &read[0];
    assert_eq!(material.base_color_factor, Vec4::ONE);
    assert_eq!((material.metallic_factor, material.roughness_factor), (1.0, 1.0));
    assert_eq!((material.normal_scale, material.occlusion_strength), (1.0, 1.0));
    assert_eq!(material.emissive_factor, Vec3::ZERO);
    assert_eq!((material.alpha_mode, material.double_sided), (AlphaMode::Opaque, false));
    assert!(material.slots.is_empty());
    assert_eq!(read[1].alpha_mode, AlphaMode::Mask(0.5));
}

#[test]
fn all_slots_with_their_settings() {
    let mut gltf = Gltf::textured(&png(2, 2));
    for color in 1..3u8 {
        let mut bytes = png(2, 2);
        // Behind the end chunk, so that the files differ and are decoded apart.
        bytes.push(color);
        let view = gltf.view(&bytes);
        gltf.push("images", json!({ "bufferView": view }));
    }
    gltf.json["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33648 }]);
    gltf.json["textures"] = json!([{ "source": 0 }, { "source": 1, "sampler": 0 }, { "source": 2 }]);
    let transform = json!({ "offset": [0.5, 0.25], "rotation": 1.5, "scale": [2, 3], "texCoord": 3 });
    gltf.json["materials"] = json!([{
        "name": "all",
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": 0, "texCoord": 1 },
            "metallicRoughnessTexture": { "index": 1, "texCoord": 1, "extensions": { "KHR_texture_transform": transform } },
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6,
        },
        "normalTexture": { "index": 2, "scale": 0.7 },
        "occlusionTexture": { "index": 1, "strength": 0.8 },
        "emissiveTexture": { "index": 0, "extensions": { "KHR_texture_transform": { "scale": [4, 4] } } },
        "emissiveFactor": [1, 2, 3], "alphaMode": "MASK", "alphaCutoff": 0.3, "doubleSided": true,
    }]);
    let read = materials(&gltf);
    let material = &read[0];
    let plain =
        TextureRef { image: 0, wrap: Wrap::default(), texcoord: 0, transform: UvTransform::default() };
    let wrap = Wrap { s: WrapMode::ClampToEdge, t: WrapMode::MirroredRepeat };
    let transform = UvTransform { offset: Vec2::new(0.5, 0.25), rotation: 1.5, scale: Vec2::new(2.0, 3.0) };
    let expected = [
        (Slot::BaseColor, TextureRef { texcoord: 1, ..plain }),
        (Slot::MetallicRoughness, TextureRef { image: 1, wrap, texcoord: 3, transform }),
        (Slot::Normal, TextureRef { image: 2, ..plain }),
        (Slot::Occlusion, TextureRef { image: 1, wrap, ..plain }),
        (
            Slot::Emissive,
            TextureRef { transform: UvTransform { scale: Vec2::splat(4.0), ..plain.transform }, ..plain },
        ),
    ];
    for (slot, reference) in expected {
        assert_eq!(material.slot(slot), Some(&reference), "{slot:?}");
    }
    assert_eq!(material.base_color_factor, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!((material.metallic_factor, material.roughness_factor), (0.5, 0.6));
    assert_eq!((material.normal_scale, material.occlusion_strength), (0.7, 0.8));
    assert_eq!(material.emissive_factor, Vec3::new(1.0, 2.0, 3.0));
    assert_eq!((material.alpha_mode, material.double_sided), (AlphaMode::Mask(0.3), true));
}

#[test]
fn a_texture_without_an_image_leaves_its_slot_empty() {
    let mut gltf = Gltf::textured(&png(2, 2));
    gltf.json["textures"][0] = json!({ "extensions": { "EXT_texture_avif": { "source": 0 } } });
    let asset = gltf.read().unwrap();
    assert!(asset.materials[0].slot(Slot::BaseColor).is_none());
    assert_eq!(asset.warnings[0].code, "texture_without_image");
    assert_eq!(asset.warnings[0].pointer, "/materials/0/pbrMetallicRoughness/baseColorTexture");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let base = "/materials/0/pbrMetallicRoughness";
    let texture = &format!("{base}/baseColorTexture");
    let transform = &format!("{texture}/extensions/KHR_texture_transform");
    let mut cases: Vec<(&str, Value, &str)> = vec![
        ("/materials/0/pbrMetallicRoughness", json!({ "baseColorTexture": { "index": 1 } }), ""),
        ("/materials/0/pbrMetallicRoughness", json!({ "baseColorTexture": {} }), ""),
        ("/textures/0", json!({ "source": 1 }), "/textures/0/source"),
        ("/textures/0", json!({ "source": 0, "sampler": 0 }), "/textures/0/sampler"),
        ("/materials/0", json!({ "alphaMode": "GLASS" }), "/materials/0"),
        ("/materials/0", json!({ "emissiveFactor": [1, 2] }), "/materials/0/emissiveFactor"),
        ("/materials/0", json!({ "doubleSided": 1 }), "/materials/0/doubleSided"),
        ("/images/0", json!({}), "/images/0"),
        ("/images/0", json!({ "uri": "a", "bufferView": 0 }), "/images/0"),
    ];
    let index = format!("{texture}/index");
    cases[0].2 = &index;
    cases[1].2 = texture;
    for (place, value, pointer) in cases {
        let mut gltf = Gltf::textured(&png(2, 2));
        *gltf.json.pointer_mut(place).unwrap() = value;
        gltf.refused(ErrorCode::InvalidModel, pointer);
    }
    let info = |extension: Value| json!({ "index": 0, "extensions": { "KHR_texture_transform": extension } });
    for (extension, pointer) in [
        (json!({ "texCoord": 16 }), transform.clone()),
        (json!({ "scale": [1e7, 1] }), transform.clone()),
        (json!({ "offset": [1] }), format!("{transform}/offset")),
        (json!({ "rotation": 1e300 }), format!("{transform}/rotation")),
    ] {
        let mut gltf = Gltf::textured(&png(2, 2));
        *gltf.json.pointer_mut(texture).unwrap() = info(extension);
        gltf.refused(ErrorCode::InvalidModel, &pointer);
    }
}

#[test]
fn vertex_colors_without_a_material_get_one() {
    let mut gltf = Gltf::triangle();
    let colors = gltf.floats("VEC3", &[0.5; 9]);
    let bare = gltf.primitive().clone();
    gltf.primitive()["attributes"]["COLOR_0"] = json!(colors);
    let colored = gltf.primitive().clone();
    let mut switching = colored.clone();
    switching["extensions"] = json!({ "KHR_materials_variants": { "mappings": [] } });
    let mut points = colored.clone();
    points["mode"] = json!(0);
    gltf.json["meshes"][0]["primitives"] = json!([bare, colored, switching, points, colored]);
    let asset = gltf.read().unwrap();
    let materials: Vec<_> = asset.meshes[0].primitives.iter().map(|own| own.material).collect();
    assert_eq!(materials, [None, Some(0), None, None, Some(0)]);
    assert_eq!((asset.materials.len(), asset.materials[0].metallic_factor), (1, 1.0));
    assert_eq!(asset.document.json["materials"], json!([{}]));
    assert_eq!(asset.document.json["meshes"][0]["primitives"][1]["material"], 0);
    assert!(asset.document.json["meshes"][0]["primitives"][0].get("material").is_none());
}
