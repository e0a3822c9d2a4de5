//! Accessors: typed stretches of buffer views, every one of the document checked before any is used,
//! and gathered into packed bytes (glTF 2.0, section 3.6.2).

use ::gltf::accessor::{DataType, Dimensions};

use super::super::budget::Budget;
use super::super::json::At;
use super::super::text::quoted;
use super::super::warnings::Warnings;
use super::quantized;
use super::views::{self, View};
use crate::error::Result;

/// All elements lie inside the view; sparse parts lie inside theirs.
#[derive(Clone, Debug)]
pub(super) struct Accessor {
    pub pointer: String,
    /// Without one, all elements are zero.
    view: Option<View>,
    offset: usize,
    pub component: DataType,
    pub normalized: bool,
    pub dimensions: Dimensions,
    pub count: usize,
    sparse: Option<Sparse>,
}

/// Elements that replace those of the view.
#[derive(Clone, Copy, Debug)]
struct Sparse {
    count: usize,
    index_type: DataType,
    indices: Stretch,
    values: Stretch,
}

/// Packed elements from `offset` of a view.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    view: View,
    offset: usize,
}

impl Accessor {
    /// Bytes of one packed element. The columns of matrices of small components are padded to 4 bytes.
    pub fn element_bytes(&self) -> usize {
        let size = self.component.size();
        let columns = match self.dimensions {
            Dimensions::Mat2 => 2,
            Dimensions::Mat3 => 3,
            Dimensions::Mat4 => 4,
            other => return size * other.multiplicity(),
        };
        columns * (size * columns).next_multiple_of(4)
    }

    pub fn describe(&self) -> String {
        let normalized = if self.normalized { " normalized" } else { "" };
        format!("{:?} {:?}{normalized}", self.dimensions, self.component)
    }
}

/// The accessors of a document with the bytes that they stand on.
pub(super) struct Store<'a> {
    buffers: &'a [Vec<u8>],
    pub views: Vec<View>,
    pub accessors: Vec<Accessor>,
    /// Whether attributes may have the types of `KHR_mesh_quantization`.
    pub quantization: bool,
}

impl<'a> Store<'a> {
    pub fn new(root: &At, buffers: &'a [Vec<u8>], warnings: &mut Warnings) -> Result<Self> {
        let views = views::read(root, buffers)?;
        let mut accessors = Vec::new();
        for at in &root.objects("accessors")? {
            accessors.push(read_one(at, &views, warnings)?);
        }
        Ok(Self { buffers, views, accessors, quantization: quantized::is_named(root)? })
    }

    pub fn view_bytes(&self, view: View) -> &'a [u8] {
        &self.buffers[view.buffer][view.offset..view.offset + view.length]
    }

    /// The elements one after the other, strides and sparse parts resolved. Counted before allocated.
    pub fn packed(&self, accessor: &Accessor, budget: &mut Budget) -> Result<Vec<u8>> {
        let element = accessor.element_bytes();
        let total = accessor.count.saturating_mul(element);
        budget.take_bytes(total as u64, &accessor.pointer)?;
        let mut packed = Vec::with_capacity(total);
        match accessor.view {
            None => packed.resize(total, 0),
            Some(view) => {
                let bytes = &self.view_bytes(view)[accessor.offset..];
                match view.stride {
                    Some(stride) if stride != element => {
                        for strided in bytes.chunks(stride).take(accessor.count) {
                            packed.extend_from_slice(&strided[..element]);
                        }
                    }
                    _ => packed.extend_from_slice(&bytes[..total]),
                }
            }
        }
        if let Some(sparse) = accessor.sparse {
            self.replace(accessor, sparse, &mut packed)?;
        }
        Ok(packed)
    }

    fn replace(&self, accessor: &Accessor, sparse: Sparse, packed: &mut [u8]) -> Result<()> {
        let element = accessor.element_bytes();
        let indices = &self.view_bytes(sparse.indices.view)[sparse.indices.offset..];
        let values = &self.view_bytes(sparse.values.view)[sparse.values.offset..];
        let mut last = None;
        let indices = indices.chunks_exact(sparse.index_type.size()).map(unsigned);
        for (number, (index, value)) in
            indices.zip(values.chunks_exact(element)).take(sparse.count).enumerate()
        {
            let wrong = |rule: String| {
                let pointer = format!("{}/sparse/indices", accessor.pointer);
                Err(crate::Error::invalid(format!("sparse index {number} is {index}: {rule}")).at(pointer))
            };
            if index as usize >= accessor.count {
                return wrong(format!("the accessor has {} elements", accessor.count));
            }
            if last.is_some_and(|last| index <= last) {
                return wrong("sparse indices must increase".to_owned());
            }
            last = Some(index);
            packed[index as usize * element..][..element].copy_from_slice(value);
        }
        Ok(())
    }
}

/// A little-endian whole number of one to four bytes.
pub(super) fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, &byte| (number << 8) | u32::from(byte))
}

fn read_one(at: &At, views: &[View], warnings: &mut Warnings) -> Result<Accessor> {
    let accessor = Accessor {
        pointer: at.pointer.clone(),
        view: at.index("bufferView", views.len(), "bufferViews")?.map(|view| views[view]),
        offset: at.size("byteOffset")?.unwrap_or(0),
        component: component(at)?,
        normalized: at.flag("normalized")?,
        dimensions: dimensions(at)?,
        count: at.need_size("count")?,
        sparse: None,
    };
    if accessor.count == 0 {
        return Err(at.error("count is 0; an accessor has at least one element"));
    }
    if accessor.normalized && matches!(accessor.component, DataType::F32 | DataType::U32) {
        return Err(at.error("only 8-bit and 16-bit components can be normalized"));
    }
    if let Some(view) = accessor.view {
        let element = accessor.element_bytes();
        let stride = view.stride.unwrap_or(element);
        if stride < element {
            return Err(at.error(format!("elements of {element} bytes overlap at a byteStride of {stride}")));
        }
        check_inside(at, view, accessor.offset, stride, element, accessor.count)?;
        if !(view.offset + accessor.offset).is_multiple_of(accessor.component.size()) {
            let detail =
                "accessors that do not begin at a multiple of their component's size; they are read anyway";
            warnings.add("unaligned_accessor", &at.pointer, detail);
        }
    }
    let sparse = at.object("sparse")?.map(|sparse| read_sparse(&sparse, &accessor, views)).transpose()?;
    Ok(Accessor { sparse, ..accessor })
}

/// All arithmetic is checked: offsets of 2^64 - 1 are among what files say.
fn check_inside(
    at: &At,
    view: View,
    offset: usize,
    stride: usize,
    element: usize,
    count: usize,
) -> Result<()> {
    let end = (count - 1)
        .checked_mul(stride)
        .and_then(|last| last.checked_add(element))
        .and_then(|length| length.checked_add(offset));
    if end.is_none_or(|end| end > view.length) {
        return Err(at.error(format!(
            "{count} elements of {element} bytes, {stride} apart, from byte {offset} reach past the end of \
             the buffer view, which has {} bytes",
            view.length
        )));
    }
    Ok(())
}

fn read_sparse(at: &At, accessor: &Accessor, views: &[View]) -> Result<Sparse> {
    let count = at.need_size("count")?;
    if count == 0 || count > accessor.count {
        return Err(at.error(format!("count is {count}; allowed is 1..={}", accessor.count)));
    }
    let part = |key: &str, element: Option<usize>| -> Result<(At, Stretch, DataType)> {
        let part = at.object(key)?.ok_or_else(|| at.error(format!("`{key}` is missing")))?;
        let view = part.need_index("bufferView", views.len(), "bufferViews")?;
        let offset = part.size("byteOffset")?.unwrap_or(0);
        let kind = if element.is_some() { accessor.component } else { component(&part)? };
        let element = element.unwrap_or(kind.size());
        check_inside(&part, views[view], offset, element, element, count)?;
        Ok((part, Stretch { view: views[view], offset }, kind))
    };
    let (indices_at, indices, index_type) = part("indices", None)?;
    if !matches!(index_type, DataType::U8 | DataType::U16 | DataType::U32) {
        return Err(indices_at.error("sparse indices are unsigned: componentType 5121, 5123 or 5125"));
    }
    let (_, values, _) = part("values", Some(accessor.element_bytes()))?;
    Ok(Sparse { count, index_type, indices, values })
}

pub(super) fn component(at: &At) -> Result<DataType> {
    let code = at.need_size("componentType")?;
    match code {
        5120 => Ok(DataType::I8),
        5121 => Ok(DataType::U8),
        5122 => Ok(DataType::I16),
        5123 => Ok(DataType::U16),
        5125 => Ok(DataType::U32),
        5126 => Ok(DataType::F32),
        _ => Err(at.error(format!("componentType {code} is not one of 5120, 5121, 5122, 5123, 5125, 5126"))),
    }
}

pub(super) fn dimensions(at: &At) -> Result<Dimensions> {
    let name = at.string("type")?.ok_or_else(|| at.error("`type` is missing"))?;
    match name {
        "SCALAR" => Ok(Dimensions::Scalar),
        "VEC2" => Ok(Dimensions::Vec2),
        "VEC3" => Ok(Dimensions::Vec3),
        "VEC4" => Ok(Dimensions::Vec4),
        "MAT2" => Ok(Dimensions::Mat2),
        "MAT3" => Ok(Dimensions::Mat3),
        "MAT4" => Ok(Dimensions::Mat4),
        _ => Err(at.error(format!("type {} is not one that glTF has", quoted(name)))),
    }
}

/// glTF's name of a type.
pub(super) fn type_name(dimensions: Dimensions) -> &'static str {
    match dimensions {
        Dimensions::Scalar => "SCALAR",
        Dimensions::Vec2 => "VEC2",
        Dimensions::Vec3 => "VEC3",
        Dimensions::Vec4 => "VEC4",
        Dimensions::Mat2 => "MAT2",
        Dimensions::Mat3 => "MAT3",
        Dimensions::Mat4 => "MAT4",
    }
}
