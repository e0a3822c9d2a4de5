//! The glTF document that stands for a file of another format: one node for each mesh, materials with their textures.
//! Primitives have no accessors and images no bytes yet; whoever writes the file adds them.

use serde_json::{Map, Value, json};

use crate::asset::{AlphaMode, EncodedImage, Material, Mesh, Slot, TextureRef, UvTransform};
use crate::image::WrapMode;

const TRANSFORM: &str = "KHR_texture_transform";

/// Textures and samplers in the order of first use.
#[derive(Default)]
struct Textures {
    samplers: Vec<WrapMode>,
    /// Image and sampler.
    list: Vec<(usize, usize)>,
    transformed: bool,
}

pub fn make(
    meshes: &[Mesh],
    materials: &[Material],
    images: &[EncodedImage],
    image_names: &[String],
) -> Value {
    let mut textures = Textures::default();
    let material_values: Vec<Value> = materials.iter().map(|m| material(m, &mut textures)).collect();
    let mut root = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": (0..meshes.len()).collect::<Vec<_>>() }],
        "nodes": meshes.iter().enumerate().map(|(index, mesh)| json!({ "name": mesh.name, "mesh": index }))
            .collect::<Vec<_>>(),
        "meshes": meshes.iter().map(mesh).collect::<Vec<_>>(),
    });
    if textures.transformed {
        root["extensionsUsed"] = json!([TRANSFORM]);
    }
    // glTF does not allow empty lists.
    let mut put = |key: &str, list: Vec<Value>| {
        if !list.is_empty() {
            root[key] = Value::Array(list);
        }
    };
    put("materials", material_values);
    let texture = |(image, sampler): &(usize, usize)| json!({ "sampler": sampler, "source": image });
    put("textures", textures.list.iter().map(texture).collect());
    let sampler = |mode: &WrapMode| {
        let code = wrap_code(*mode);
        json!({ "wrapS": code, "wrapT": code })
    };
    put("samplers", textures.samplers.iter().map(sampler).collect());
    let image =
        |(image, name): (&EncodedImage, &String)| json!({ "name": name, "mimeType": image.media_type });
    put("images", images.iter().zip(image_names).map(image).collect());
    root
}

fn wrap_code(mode: WrapMode) -> u32 {
    match mode {
        WrapMode::Repeat => 10497,
        WrapMode::MirroredRepeat => 33648,
        WrapMode::ClampToEdge => 33071,
    }
}

fn mesh(mesh: &Mesh) -> Value {
    let primitive = |material: Option<usize>| match material {
        Some(material) => json!({ "material": material }),
        None => json!({}),
    };
    let primitives: Vec<Value> = mesh.primitives.iter().map(|p| primitive(p.material)).collect();
    json!({ "name": mesh.name, "primitives": primitives })
}

fn material(material: &Material, textures: &mut Textures) -> Value {
    let mut pbr = Map::new();
    pbr.insert("baseColorFactor".to_owned(), json!(material.base_color_factor.to_array()));
    pbr.insert("metallicFactor".to_owned(), json!(material.metallic_factor));
    pbr.insert("roughnessFactor".to_owned(), json!(material.roughness_factor));
    let mut value = Map::new();
    value.insert("name".to_owned(), json!(material.name));
    value.insert("emissiveFactor".to_owned(), json!(material.emissive_factor.to_array()));
    if material.alpha_mode == AlphaMode::Blend {
        value.insert("alphaMode".to_owned(), json!("BLEND"));
    }
    for slot in Slot::CORE {
        let Some(reference) = material.slot(slot) else { continue };
        let mut info = textures.info(reference);
        if slot == Slot::Normal {
            info["scale"] = json!(material.normal_scale);
        }
        let holder = if slot.path().len() > 1 { &mut pbr } else { &mut value };
        holder.insert(slot.gltf_name().to_owned(), info);
    }
    value.insert("pbrMetallicRoughness".to_owned(), Value::Object(pbr));
    Value::Object(value)
}

impl Textures {
    fn info(&mut self, reference: &TextureRef) -> Value {
        let sampler = number_of(&mut self.samplers, reference.wrap.s);
        let index = number_of(&mut self.list, (reference.image, sampler));
        let mut info = json!({ "index": index });
        let transform = reference.transform;
        if transform != UvTransform::default() {
            self.transformed = true;
            info["extensions"] = json!({
                TRANSFORM: { "offset": transform.offset.to_array(), "scale": transform.scale.to_array() }
            });
        }
        info
    }
}

/// The place of an item, which is appended where it is new. Samplers are two at most; textures are as
/// many as images, which the limit on files keeps few.
fn number_of<T: PartialEq>(list: &mut Vec<T>, item: T) -> usize {
    list.iter().position(|known| *known == item).unwrap_or_else(|| {
        list.push(item);
        list.len() - 1
    })
}
