//! A Draco stream to plain arrays. What comes out is held against what the document says of it.

use ::gltf::accessor::DataType;
use draco_core::{
    AttributeValueIndex, DataType as Stored, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute,
    PointIndex,
};

/// What the document says of a compressed primitive.
#[derive(Clone, Copy, Debug)]
pub struct Expected {
    pub point_count: usize,
    pub index_count: usize,
    /// Most that all attributes of the stream may take, in bytes.
    pub bytes_max: u64,
}

pub struct Stream(Mesh);

impl Stream {
    /// # Errors
    /// What is wrong with the stream, in words.
    pub fn decode(packed: &[u8], expected: Expected) -> Result<Self, String> {
        let Expected { point_count, index_count, bytes_max } = expected;
        let limits = DecodeLimits::default()
            .with_max_points(point_count as u64)
            .with_max_faces(index_count as u64 / 3)
            .with_max_decoded_bytes(bytes_max);
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(packed).with_limits(limits);
        MeshDecoder::new()
            .decode(&mut buffer, &mut mesh)
            .map_err(|error| format!("the Draco stream cannot be decoded: {error}"))?;
        if mesh.num_points() != point_count || mesh.num_faces().checked_mul(3) != Some(index_count) {
            return Err(format!(
                "the Draco stream has {} vertices and {} triangles; its accessors have {point_count} elements and \
                 {index_count} indices",
                mesh.num_points(),
                mesh.num_faces()
            ));
        }
        Ok(Self(mesh))
    }

    /// Three vertex numbers for each triangle.
    pub fn indices(&self) -> impl Iterator<Item = u32> + '_ {
        self.0.faces().iter().flatten().map(|point| point.0)
    }

    /// The attribute of this id for all vertices, `width` numbers of `component` each, at distances of
    /// `stride` bytes.
    ///
    /// # Errors
    /// Where the stream lacks it or has it in a form that does not fit.
    pub fn attribute(
        &self,
        id: u32,
        component: DataType,
        width: usize,
        stride: usize,
    ) -> Result<Vec<u8>, String> {
        let attribute = self.0.attribute_by_unique_id(id).ok_or_else(|| {
            format!("the Draco stream has no attribute with the id {id}; it has {}", self.0.num_attributes())
        })?;
        if usize::from(attribute.num_components()) != width {
            let actual = attribute.num_components();
            return Err(format!(
                "attribute {id} of the stream has {actual} components, its accessor has {width}"
            ));
        }
        let mut bytes = vec![0; self.0.num_points() * stride];
        for (point, target) in bytes.chunks_exact_mut(stride).enumerate() {
            let stored = value(attribute, attribute.mapped_index(PointIndex(point as u32)), width)
                .ok_or_else(|| format!("attribute {id} of the stream has no value for vertex {point}"))?;
            let from = stored.chunks_exact(attribute.data_type().byte_length());
            for (from, to) in from.zip(target.chunks_exact_mut(component.size())) {
                if !put(attribute.data_type(), from, component, to) {
                    return Err(format!(
                        "attribute {id} of the stream is {:?}; vertex {point} does not fit its accessor's {component:?}",
                        attribute.data_type()
                    ));
                }
            }
        }
        Ok(bytes)
    }
}

fn value(attribute: &PointAttribute, index: AttributeValueIndex, width: usize) -> Option<&[u8]> {
    let index = usize::try_from(index.0).ok().filter(|index| *index < attribute.size())?;
    let start = index.checked_mul(usize::try_from(attribute.byte_stride()).ok()?)?;
    let length = width.checked_mul(attribute.data_type().byte_length()).filter(|length| *length > 0)?;
    attribute.buffer().data().get(start..start.checked_add(length)?)
}

/// One number into another type, if it stays the same.
fn put(stored: Stored, from: &[u8], component: DataType, to: &mut [u8]) -> bool {
    if component == DataType::F32 {
        if stored != Stored::Float32 {
            return false;
        }
        to.copy_from_slice(from);
        return true;
    }
    let is_signed = match stored {
        Stored::Int8 | Stored::Int16 | Stored::Int32 => true,
        Stored::Uint8 | Stored::Uint16 | Stored::Uint32 => false,
        _ => return false,
    };
    let code = from.iter().rev().fold(0i64, |code, &byte| (code << 8) | i64::from(byte));
    let unused = 64 - 8 * from.len() as u32;
    let code = if is_signed { (code << unused) >> unused } else { code };
    let range = match component {
        DataType::I8 => i64::from(i8::MIN)..=i64::from(i8::MAX),
        DataType::U8 => 0..=i64::from(u8::MAX),
        DataType::I16 => i64::from(i16::MIN)..=i64::from(i16::MAX),
        DataType::U16 => 0..=i64::from(u16::MAX),
        DataType::U32 => 0..=i64::from(u32::MAX),
        DataType::F32 => return false,
    };
    if !range.contains(&code) {
        return false;
    }
    to.copy_from_slice(&code.to_le_bytes()[..to.len()]);
    true
}
