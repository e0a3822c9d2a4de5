//! Written files that lie afterwards: reading them back finds each lie and says where it is.

use serde_json::{Value, json};

use super::{fixture, parse};
use crate::asset::{Asset, Attribute};
use crate::error::ErrorCode;
use crate::finished::extract;

fn converted() -> Asset {
    parse::asset(&fixture::converted().2)
}

/// The error's place and text after a change to a sound file.
fn lie(change: impl FnOnce(&mut Asset)) -> (String, String) {
    let mut asset = converted();
    assert!(extract(&asset).unwrap().is_some());
    change(&mut asset);
    let error = extract(&asset).unwrap_err();
    assert_eq!(error.code, ErrorCode::InvalidModel);
    (error.pointer.unwrap_or_default(), error.detail)
}

fn expect(lie: (String, String), pointer: &str, rule: &str) {
    assert!(lie.0.starts_with(pointer) && lie.1.contains(rule), "{lie:?}");
}

fn texture(asset: &mut Asset) -> &mut Value {
    let json = &mut asset.document.json;
    let number = json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"].as_u64().unwrap();
    &mut json["textures"][number as usize]
}

fn levels(asset: &mut Asset) -> &mut Value {
    &mut texture(asset)["extensions"]["MCT_mesh_color_texture"]["levels"]
}

fn attribute<'a>(asset: &'a mut Asset, name: &str) -> &'a mut Attribute {
    let attributes = &mut asset.meshes[0].primitives[0].attributes;
    attributes.iter_mut().find(|attribute| attribute.semantic == name).unwrap()
}

fn extension(asset: &mut Asset) -> &mut Value {
    &mut asset.document.json["meshes"][0]["primitives"][0]["extensions"]["MCT_mesh_color_texture"]
}

fn cuts_accessor(asset: &mut Asset) -> &mut Value {
    let number = extension(asset)["cuts"]["occlusionTexture"].as_u64().unwrap();
    &mut asset.document.json["accessors"][number as usize]
}

#[test]
fn a_plain_file_holds_no_conversion() {
    assert_eq!(extract(&parse::asset(&fixture::source_glb())).unwrap(), None);
    assert_eq!(extract(&Asset::default()).unwrap(), None);
}

#[test]
fn levels_are_images_of_the_file() {
    let place = "/textures/";
    expect(lie(|asset| *levels(asset) = json!([])), place, "1 to 32 image numbers");
    expect(lie(|asset| *levels(asset) = json!("0")), place, "1 to 32 image numbers");
    expect(lie(|asset| levels(asset)[1] = 99.into()), place, "not one of the file's");
    expect(lie(|asset| levels(asset)[1] = (-1).into()), place, "not one of the file's");
    expect(lie(|asset| texture(asset)["source"] = 0.into()), place, "has to be the texture's \"source\"");
    let count = |asset: &mut Asset| {
        texture(asset).as_object_mut().unwrap().remove("source");
    };
    expect(lie(count), place, "has to be the texture's \"source\"");
}

#[test]
fn textures_of_one_material_share_their_sizes() {
    let fewer = lie(|asset| {
        levels(asset).as_array_mut().unwrap().pop();
    });
    expect(fewer, "/materials/0", "same sizes at every level");
    let swapped = lie(|asset| levels(asset).as_array_mut().unwrap().swap(1, 2));
    expect(swapped, "/materials/0", "same sizes at every level");
    let mixed = lie(|asset| {
        let other = asset.document.json["materials"][0]["normalTexture"]["index"].as_u64().unwrap() as usize;
        let last = asset.document.json["textures"][other]["extensions"]["MCT_mesh_color_texture"]["levels"]
            [2]
        .clone();
        levels(asset)[2] = last;
    });
    expect(mixed, "/textures/", "of level 0");
}

/// What is said of a sound file with ranges on levels 1 and 2, after a change to a list of them.
fn range_lie(change: impl FnOnce(&mut Value)) -> (String, String) {
    let (asset, finished) = fixture::ranged();
    let glb = crate::write::glb(&asset, &finished, &crate::watch::Unwatched).unwrap().bytes;
    let mut asset = parse::asset(&glb);
    assert_eq!(extract(&asset).unwrap().unwrap().textures, finished.textures);
    let textures = asset.document.json["textures"].as_array_mut().unwrap();
    let ranges = textures
        .iter_mut()
        .filter_map(|texture| texture["extensions"]["MCT_mesh_color_texture"].get_mut("ranges"))
        .find(|ranges| ranges[0]["format"] == "scaled16");
    change(ranges.unwrap());
    let error = extract(&asset).unwrap_err();
    assert_eq!(error.code, ErrorCode::InvalidModel);
    (error.pointer.unwrap_or_default(), error.detail)
}

#[test]
fn ranges_fit_their_images() {
    let place = "/textures/";
    expect(range_lie(|ranges| *ranges = json!({})), place, "list of objects");
    for level in [json!(0), json!(3), json!(-1), json!("1"), Value::Null] {
        expect(range_lie(|ranges| ranges[0]["level"] = level), place, "one of 1 to 2");
    }
    let twice = |ranges: &mut Value| {
        let first = ranges[0].clone();
        ranges.as_array_mut().unwrap().push(first);
    };
    expect(range_lie(twice), place, "has two ranges");
    expect(range_lie(|ranges| ranges[0]["format"] = "float64".into()), place, "\"scaled16\" or \"float16\"");
    // The codes of the fixture are noise: some are bits of no number.
    expect(range_lie(|ranges| ranges[0]["format"] = "float16".into()), place, "no numbers");
    for (name, value) in [
        ("scale", json!(0.0)),
        ("scale", json!(-1.0)),
        ("scale", json!(1e39)),
        ("bias", json!(-1e39)),
        ("bias", Value::Null),
    ] {
        expect(range_lie(|ranges| ranges[0][name][0] = value), place, &format!("\"{name}\" has to be"));
    }
    expect(
        range_lie(|ranges| ranges[0]["bias"].as_array_mut().unwrap().clear()),
        place,
        "\"bias\" has to be",
    );
    let shallow = lie(|asset| {
        let textures = asset.document.json["textures"].as_array_mut().unwrap();
        for texture in textures.iter_mut().filter(|texture| texture["extensions"].is_object()) {
            texture["extensions"]["MCT_mesh_color_texture"]["ranges"] =
                json!([{ "level": 1, "format": "float16" }]);
        }
    });
    assert!(shallow.1.contains("16 bits") || shallow.1.contains("no numbers"), "{shallow:?}");
}

#[test]
fn color_and_data_do_not_share_a_texture() {
    let shared = lie(|asset| {
        let base = asset.document.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"].clone();
        asset.document.json["materials"][0]["occlusionTexture"] = base;
    });
    expect(shared, "/materials/0", "as color and as data");
}

#[test]
fn coordinates_are_complete_and_sound() {
    let place = "/meshes/0/primitives/0/attributes";
    for name in ["_MCT_SCALED", "_MCT_OFFSET"] {
        let missing = lie(|asset| attribute(asset, name).semantic = "_OTHER".to_owned());
        expect(missing, place, &format!("{name} is missing"));
        let at = format!("{place}/{name}");
        expect(lie(|asset| attribute(asset, name).kind = "VEC3".to_owned()), &at, "VEC2");
        expect(lie(|asset| attribute(asset, name).normalized = true), &at, "not normalized");
        let short = lie(|asset| {
            attribute(asset, name).bytes.pop();
        });
        expect(short, &at, "one for each vertex");
        let endless = f32::NAN.to_le_bytes();
        expect(lie(|asset| attribute(asset, name).bytes[..4].copy_from_slice(&endless)), &at, "finite");
        let far = 1e7f32.to_le_bytes();
        expect(lie(|asset| attribute(asset, name).bytes[..4].copy_from_slice(&far)), &at, "within");
    }
    let varying =
        lie(|asset| attribute(asset, "_MCT_OFFSET").bytes[8..12].copy_from_slice(&3f32.to_le_bytes()));
    expect(varying, &format!("{place}/_MCT_OFFSET"), "triangle 0: the offset has to be the same");
}

#[test]
fn scaled_coordinates_may_be_whole_texels() {
    let mut asset = converted();
    let attribute = attribute(&mut asset, "_MCT_SCALED");
    let whole: Vec<u16> = (0..attribute.bytes.len() as u16 / 4).collect();
    attribute.component_type = 5123;
    attribute.element_bytes = 4;
    attribute.bytes = whole.iter().flat_map(|code| code.to_le_bytes()).collect();
    let finished = extract(&asset).unwrap().unwrap();
    let triangle = finished.primitives[0].triangles[0];
    assert_eq!(triangle.corners[1], glam::Vec2::new(2.0, 3.0));
}

#[test]
fn a_normal_map_needs_its_frames() {
    for clear in [
        |asset: &mut Asset| asset.meshes[0].primitives[0].normals.clear(),
        |asset: &mut Asset| {
            asset.meshes[0].primitives[0].tangents.clear();
        },
    ] {
        expect(lie(clear), "/meshes/0/primitives/0/attributes", "NORMAL and TANGENT");
    }
}

#[test]
fn cuts_are_one_byte_for_each_triangle() {
    let place = "/meshes/0/primitives/0/extensions/MCT_mesh_color_texture/cuts/";
    let at = format!("{place}metallicRoughnessTexture");
    expect(lie(|asset| cuts_accessor(asset)["count"] = 3.into()), &at, "3 values for 2 triangles");
    expect(lie(|asset| cuts_accessor(asset)["componentType"] = 5123.into()), &at, "UNSIGNED_BYTE");
    expect(lie(|asset| cuts_accessor(asset)["byteOffset"] = 1.into()), &at, "leaves its buffer view");
    expect(lie(|asset| cuts_accessor(asset)["byteOffset"] = u64::MAX.into()), &at, "leaves its buffer view");
    expect(lie(|asset| cuts_accessor(asset)["bufferView"] = 999.into()), &at, "needs a buffer view");
    let bits = lie(|asset| {
        let view = cuts_accessor(asset)["bufferView"].as_u64().unwrap() as usize;
        let start = asset.document.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize;
        asset.document.buffers[0][start] = 8;
    });
    expect(bits, &at, "only bits 0 to 2");
    let unknown = lie(|asset| extension(asset)["cuts"]["emissiveTexture"] = 0.into());
    expect(unknown, &format!("{place}emissiveTexture"), "no converted texture of this name");
    let one_of_two = lie(|asset| {
        extension(asset)["cuts"].as_object_mut().unwrap().remove("occlusionTexture");
    });
    expect(one_of_two, &format!("{place}occlusionTexture"), "same cuts");
}
