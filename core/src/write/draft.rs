//! The glTF file in the making: the source's JSON, with its shared arrays taken out so that they can
//! grow and shrink, and the bytes of each buffer view. All buffers become one, the GLB's binary chunk.

use std::borrow::Cow;

use serde_json::{Map, Value, json};

use crate::asset::Document;
use crate::error::{Error, Result};
use crate::vertex_codec;

const GLB_MAGIC: u32 = 0x4654_6C67;
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;
/// Largest GLB: its header counts bytes in 32 bits.
const GLB_BYTES_MAX: u64 = u32::MAX as u64;

/// A buffer view and its bytes.
pub struct View<'a> {
    /// Without `buffer`, `byteOffset` and `byteLength`.
    pub json: Map<String, Value>,
    /// `None` where the source's view lies outside of its buffer: an error only if it is kept.
    pub bytes: Option<Cow<'a, [u8]>>,
    /// Where the bytes are packed.
    pub packing: Option<Packing>,
}

/// How the bytes of a view are packed.
pub struct Packing {
    /// The members of the extension, without buffer and place.
    pub json: Map<String, Value>,
    pub unpacked_bytes: usize,
}

pub struct Draft<'a> {
    /// Everything but the arrays below.
    pub root: Map<String, Value>,
    pub views: Vec<View<'a>>,
    pub accessors: Vec<Value>,
    pub images: Vec<Value>,
    pub samplers: Vec<Value>,
    pub textures: Vec<Value>,
    pub materials: Vec<Value>,
    pub meshes: Vec<Value>,
}

impl<'a> Draft<'a> {
    pub fn open(document: &'a Document) -> Result<Self> {
        let mut root = match &document.json {
            Value::Object(root) => root.clone(),
            Value::Null => Map::new(),
            _ => return Err(Error::internal("the document's JSON is not an object")),
        };
        let mut take = |name: &str| match root.remove(name) {
            Some(Value::Array(items)) => items,
            _ => Vec::new(),
        };
        Ok(Self {
            views: take("bufferViews").into_iter().map(|view| open_view(view, document)).collect(),
            accessors: take("accessors"),
            images: take("images"),
            samplers: take("samplers"),
            textures: take("textures"),
            materials: take("materials"),
            meshes: take("meshes"),
            root,
        })
    }

    /// Appends a buffer view of its own bytes; `target` is 34962 (vertices), 34963 (indices) or none.
    pub fn add_view(
        &mut self,
        bytes: impl Into<Cow<'a, [u8]>>,
        target: Option<u32>,
        stride_bytes: Option<usize>,
    ) -> usize {
        let mut json = Map::new();
        if let Some(stride) = stride_bytes {
            json.insert("byteStride".to_owned(), stride.into());
        }
        if let Some(target) = target {
            json.insert("target".to_owned(), target.into());
        }
        self.views.push(View { json, bytes: Some(bytes.into()), packing: None });
        self.views.len() - 1
    }

    /// The JSON object of a primitive, which is made if the document lacks it.
    pub fn primitive(&mut self, mesh: usize, primitive: usize) -> &mut Map<String, Value> {
        object(at(self.primitives(mesh), primitive))
    }

    /// The primitives of a mesh, which are made if the document lacks them.
    pub fn primitives(&mut self, mesh: usize) -> &mut Vec<Value> {
        let mesh = object(at(&mut self.meshes, mesh));
        let primitives = mesh.entry("primitives").or_insert_with(|| json!([]));
        if !primitives.is_array() {
            *primitives = json!([]);
        }
        match primitives {
            Value::Array(items) => items,
            _ => unreachable!("it was made an array above"),
        }
    }

    /// Puts everything together: JSON chunk, then binary chunk, each padded to four bytes.
    pub fn into_glb(mut self) -> Result<Vec<u8>> {
        let mut chunks = Vec::with_capacity(self.views.len());
        let mut views = Vec::with_capacity(self.views.len());
        let [mut offset, mut fallback] = [0usize; 2];
        for (number, view) in self.views.into_iter().enumerate() {
            let bytes = view.bytes.ok_or_else(|| {
                Error::invalid("the buffer view lies outside of its buffer")
                    .at(format!("/bufferViews/{number}"))
            })?;
            let place = |buffer: usize, offset: usize, length: usize| {
                [("buffer", buffer), ("byteOffset", offset), ("byteLength", length)]
                    .map(|(name, number)| (name.to_owned(), number.into()))
            };
            let mut json = Map::from_iter(place(0, offset, bytes.len()));
            if let Some(packing) = view.packing {
                let mut own = Map::from_iter(place(0, offset, bytes.len()));
                own.extend(packing.json);
                json = Map::from_iter(place(1, fallback, packing.unpacked_bytes));
                member(&mut json, "extensions").insert(vertex_codec::EXTENSION.to_owned(), own.into());
                fallback += padded(packing.unpacked_bytes);
            }
            json.extend(view.json);
            views.push(Value::Object(json));
            offset += padded(bytes.len());
            chunks.push(bytes);
        }
        // The bytes that the views need: padding after the last one is the chunk's, not the buffer's.
        let mut buffers = buffers(self.root.get("buffers"), offset);
        if fallback > 0 {
            let extension = json!({ vertex_codec::EXTENSION: { "fallback": true } });
            buffers.push(json!({ "byteLength": fallback, "extensions": extension }));
        }
        let mut listed = |name: &str| match self.root.shift_remove(name) {
            Some(Value::Array(items)) => items,
            _ => Vec::new(),
        };
        // In one order, whatever the source had of them and where.
        let [used, required] = ["extensionsUsed", "extensionsRequired"].map(&mut listed);
        listed("buffers");
        for (name, items) in [
            ("extensionsUsed", used),
            ("extensionsRequired", required),
            ("buffers", buffers),
            ("bufferViews", views),
            ("accessors", self.accessors),
            ("images", self.images),
            ("samplers", self.samplers),
            ("textures", self.textures),
            ("materials", self.materials),
            ("meshes", self.meshes),
        ] {
            set_array(&mut self.root, name, items);
        }
        if !self.root.contains_key("asset") {
            let generator = concat!("meshcolor ", env!("CARGO_PKG_VERSION"));
            self.root.insert("asset".to_owned(), json!({ "version": "2.0", "generator": generator }));
        }
        container(&Value::Object(self.root), chunks, offset)
    }
}

/// The one buffer, with what the source said of its first.
fn buffers(source: Option<&Value>, byte_length: usize) -> Vec<Value> {
    if byte_length == 0 {
        return Vec::new();
    }
    let mut first = source.and_then(|all| all.get(0)).and_then(Value::as_object).cloned().unwrap_or_default();
    first.remove("uri");
    first.remove("extensions");
    first.insert("byteLength".to_owned(), byte_length.into());
    vec![Value::Object(first)]
}

fn open_view<'a>(view: Value, document: &'a Document) -> View<'a> {
    let mut json = match view {
        Value::Object(json) => json,
        _ => Map::new(),
    };
    let mut number = |name: &str| json.remove(name).and_then(|value| value.as_u64());
    let (buffer, offset) = (number("buffer"), number("byteOffset").unwrap_or(0));
    let bytes = number("byteLength").and_then(|length| {
        let buffer = document.buffers.get(usize::try_from(buffer?).ok()?)?;
        let start = usize::try_from(offset).ok()?;
        buffer.get(start..start.checked_add(usize::try_from(length).ok()?)?)
    });
    View { json, bytes: bytes.map(Cow::Borrowed), packing: None }
}

fn container(json: &Value, chunks: Vec<Cow<'_, [u8]>>, bin_bytes: usize) -> Result<Vec<u8>> {
    let mut text = serde_json::to_vec(json).map_err(|error| Error::internal(error.to_string()))?;
    text.resize(padded(text.len()), b' ');
    let bin_total = if bin_bytes == 0 { 0 } else { 8 + bin_bytes };
    let total = 12 + 8 + text.len() + bin_total;
    if total as u64 > GLB_BYTES_MAX {
        return Err(Error::new(
            crate::ErrorCode::ModelTooLarge,
            "the converted file would be larger than a GLB can be; lower the resolution",
        )
        .limit(GLB_BYTES_MAX, total as u64));
    }
    let mut glb = Vec::with_capacity(total);
    for word in [GLB_MAGIC, 2, total as u32, text.len() as u32, CHUNK_JSON] {
        glb.extend_from_slice(&word.to_le_bytes());
    }
    glb.extend_from_slice(&text);
    if bin_bytes > 0 {
        glb.extend_from_slice(&(bin_bytes as u32).to_le_bytes());
        glb.extend_from_slice(&CHUNK_BIN.to_le_bytes());
        for chunk in chunks {
            glb.extend_from_slice(&chunk);
            glb.resize(padded(glb.len()), 0);
        }
    }
    Ok(glb)
}

/// glTF forbids empty arrays.
fn set_array(root: &mut Map<String, Value>, name: &str, items: Vec<Value>) {
    if items.is_empty() {
        root.remove(name);
    } else {
        root.insert(name.to_owned(), Value::Array(items));
    }
}

fn padded(bytes: usize) -> usize {
    bytes.div_ceil(4) * 4
}

/// The item at `index`, with empty objects before it where the array is too short.
pub fn at(items: &mut Vec<Value>, index: usize) -> &mut Value {
    while items.len() <= index {
        items.push(Value::Object(Map::new()));
    }
    &mut items[index]
}

/// The value as an object, which it becomes if it is something else.
pub fn object(value: &mut Value) -> &mut Map<String, Value> {
    if !value.is_object() {
        *value = Value::Object(Map::new());
    }
    match value {
        Value::Object(map) => map,
        _ => unreachable!("it was made an object above"),
    }
}

/// The member `name` of an object as an object, made where it is missing.
pub fn member<'m>(map: &'m mut Map<String, Value>, name: &str) -> &'m mut Map<String, Value> {
    object(map.entry(name.to_owned()).or_insert(Value::Null))
}

/// Removes a member of `map.extensions`, and `extensions` itself when nothing is left in it.
pub fn remove_extension(map: &mut Map<String, Value>, name: &str) {
    if let Some(Value::Object(extensions)) = map.get_mut("extensions") {
        extensions.remove(name);
        if extensions.is_empty() {
            map.remove("extensions");
        }
    }
}

/// A member that is an index.
pub fn index(value: &Value, name: &str) -> Option<usize> {
    value.get(name)?.as_u64().and_then(|number| usize::try_from(number).ok())
}
