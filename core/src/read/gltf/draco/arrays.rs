//! The arrays that accessors get out of a stream, in the form that they ask for.

use ::gltf::accessor::DataType;

use super::super::super::json::At;
use super::super::accessors::{component, dimensions};
use super::stream::Stream;
use crate::error::Result;

const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The elements of an accessor that had none in plain.
pub struct Array {
    pub bytes: Vec<u8>,
    /// Where it is not the size of an element.
    pub stride: Option<usize>,
    pub target: u32,
    /// Floats in an element, where they are floats.
    float_count: Option<usize>,
}

impl Array {
    /// Smallest and largest of each component, of floats.
    pub fn bounds(&self) -> Option<[Vec<f32>; 2]> {
        let width = self.float_count?;
        let mut bounds = [vec![f32::INFINITY; width], vec![f32::NEG_INFINITY; width]];
        for (number, four) in self.bytes.chunks_exact(4).enumerate() {
            let value = f32::from_le_bytes([four[0], four[1], four[2], four[3]]);
            let component = number % width;
            bounds[0][component] = bounds[0][component].min(value);
            bounds[1][component] = bounds[1][component].max(value);
        }
        Some(bounds)
    }
}

/// What an accessor says of its elements.
pub struct Form<'a> {
    pub at: &'a At<'a>,
    pub component: DataType,
    pub width: usize,
    pub count: usize,
}

impl<'a> Form<'a> {
    pub fn of(at: &'a At<'a>) -> Result<Self> {
        let (component, width) = (component(at)?, dimensions(at)?.multiplicity());
        Ok(Self { at, component, width, count: at.need_size("count")? })
    }

    /// Vertex attributes stand at multiples of 4 bytes.
    pub fn stride(&self) -> usize {
        (self.component.size() * self.width).next_multiple_of(4)
    }
}

/// # Errors
/// What does not fit, in words.
pub fn vertices(stream: &Stream, id: u32, form: &Form) -> std::result::Result<Array, String> {
    let stride = form.stride();
    let bytes = stream.attribute(id, form.component, form.width, stride)?;
    let float_count = (form.component == DataType::F32).then_some(form.width);
    let is_padded = stride != form.component.size() * form.width;
    Ok(Array { bytes, stride: is_padded.then_some(stride), target: VERTICES, float_count })
}

pub fn triangles(stream: &Stream, form: &Form) -> Result<Array> {
    let size = form.component.size();
    let (true, Some(largest)) = (form.width == 1, largest(form.component)) else {
        return Err(form.at.error("indices are SCALAR of componentType 5121, 5123 or 5125"));
    };
    let mut bytes = Vec::with_capacity(form.count * size);
    for index in stream.indices() {
        if index > largest {
            return Err(form
                .at
                .error(format!("index {index} of the Draco stream needs a larger componentType")));
        }
        bytes.extend_from_slice(&index.to_le_bytes()[..size]);
    }
    Ok(Array { bytes, stride: None, target: INDICES, float_count: None })
}

fn largest(component: DataType) -> Option<u32> {
    match component {
        DataType::U8 => Some(u8::MAX.into()),
        DataType::U16 => Some(u16::MAX.into()),
        DataType::U32 => Some(u32::MAX),
        _ => None,
    }
}
