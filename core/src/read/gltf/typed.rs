//! Packed elements to numbers: the vertex attributes and indices that the conversion computes with.

use ::gltf::accessor::{DataType, Dimensions};
use glam::{Vec2, Vec3, Vec4};

use super::super::budget::Budget;
use super::super::geometry::{POSITION_MAX, UV_MAX, check_finite};
use super::accessors::{Accessor, Store, unsigned};
use crate::error::{Error, Result};

fn wrong_type(accessor: &Accessor, semantic: &str, allowed: &str) -> Error {
    let detail = format!("{semantic} must be {allowed}, but the accessor is {}", accessor.describe());
    Error::invalid(detail).at(accessor.pointer.clone())
}

fn floats<const N: usize>(packed: &[u8]) -> impl Iterator<Item = [f32; N]> + '_ {
    packed.chunks_exact(4 * N).map(|element| {
        let mut numbers = [0.0; N];
        for (number, four) in numbers.iter_mut().zip(element.chunks_exact(4)) {
            *number = f32::from_bits(unsigned(four));
        }
        numbers
    })
}

/// An attribute of floats, all finite and within `max`.
fn float_vectors<const N: usize>(
    store: &Store,
    accessor: &Accessor,
    (semantic, dimensions, max): (&str, Dimensions, f32),
    budget: &mut Budget,
) -> Result<Vec<[f32; N]>> {
    if accessor.component != DataType::F32 || accessor.dimensions != dimensions {
        let allowed =
            format!("{dimensions:?} F32 (others need KHR_mesh_quantization, which is not understood)");
        return Err(wrong_type(accessor, semantic, &allowed));
    }
    let packed = store.packed(accessor, budget)?;
    let vectors: Vec<[f32; N]> = floats(&packed).collect();
    check_vectors(&vectors, semantic, max, accessor)?;
    Ok(vectors)
}

fn check_vectors<const N: usize>(
    vectors: &[[f32; N]],
    semantic: &str,
    max: f32,
    accessor: &Accessor,
) -> Result<()> {
    let place = |element: usize| format!("{semantic}, element {element}");
    check_finite(vectors.iter().flatten().copied(), N, max, place)
        .map_err(|error| error.at(accessor.pointer.clone()))
}

pub(super) fn positions(store: &Store, accessor: &Accessor, budget: &mut Budget) -> Result<Vec<Vec3>> {
    let vectors = float_vectors(store, accessor, ("POSITION", Dimensions::Vec3, POSITION_MAX), budget)?;
    Ok(vectors.into_iter().map(Vec3::from_array).collect())
}

pub(super) fn normals(store: &Store, accessor: &Accessor, budget: &mut Budget) -> Result<Vec<Vec3>> {
    let vectors = float_vectors(store, accessor, ("NORMAL", Dimensions::Vec3, f32::MAX), budget)?;
    Ok(vectors.into_iter().map(Vec3::from_array).collect())
}

pub(super) fn tangents(store: &Store, accessor: &Accessor, budget: &mut Budget) -> Result<Vec<Vec4>> {
    let vectors = float_vectors(store, accessor, ("TANGENT", Dimensions::Vec4, f32::MAX), budget)?;
    Ok(vectors.into_iter().map(Vec4::from_array).collect())
}

/// Floats, or 8-bit or 16-bit codes over their largest.
pub(super) fn texcoords(
    store: &Store,
    accessor: &Accessor,
    semantic: &str,
    budget: &mut Budget,
) -> Result<Vec<Vec2>> {
    let code_max = match (accessor.dimensions, accessor.component, accessor.normalized) {
        (Dimensions::Vec2, DataType::F32, _) => {
            let vectors = float_vectors(store, accessor, (semantic, Dimensions::Vec2, UV_MAX), budget)?;
            return Ok(vectors.into_iter().map(Vec2::from_array).collect());
        }
        (Dimensions::Vec2, DataType::U8, true) => 255.0,
        (Dimensions::Vec2, DataType::U16, true) => 65535.0,
        _ => return Err(wrong_type(accessor, semantic, "Vec2 of F32, or U8 or U16 normalized")),
    };
    let packed = store.packed(accessor, budget)?;
    let size = accessor.component.size();
    let code = |bytes: &[u8]| unsigned(bytes) as f32 / code_max;
    Ok(packed.chunks_exact(2 * size).map(|uv| Vec2::new(code(&uv[..size]), code(&uv[size..]))).collect())
}

/// Unsigned whole numbers.
pub(super) fn whole_numbers(
    store: &Store,
    accessor: &Accessor,
    (semantic, dimensions): (&str, Dimensions),
    budget: &mut Budget,
) -> Result<Vec<u32>> {
    let is_whole = matches!(accessor.component, DataType::U8 | DataType::U16 | DataType::U32);
    if !is_whole || accessor.normalized || accessor.dimensions != dimensions {
        let allowed = format!("{dimensions:?} of U8, U16 or U32, not normalized");
        return Err(wrong_type(accessor, semantic, &allowed));
    }
    let packed = store.packed(accessor, budget)?;
    Ok(packed.chunks_exact(accessor.component.size()).map(unsigned).collect())
}

/// Finite floats, one after the other.
pub(super) fn finite_floats(
    store: &Store,
    accessor: &Accessor,
    (semantic, dimensions): (&str, Dimensions),
    budget: &mut Budget,
) -> Result<Vec<f32>> {
    if accessor.component != DataType::F32 || accessor.dimensions != dimensions {
        return Err(wrong_type(accessor, semantic, &format!("{dimensions:?} F32")));
    }
    let packed = store.packed(accessor, budget)?;
    let numbers: Vec<f32> = floats::<1>(&packed).map(|[number]| number).collect();
    let place = |number: usize| format!("{semantic}, number {number}");
    check_finite(numbers.iter().copied(), 1, f32::MAX, place)
        .map_err(|error| error.at(accessor.pointer.clone()))?;
    Ok(numbers)
}

/// Vertex indices, each below `vertex_count`.
pub(super) fn indices(
    store: &Store,
    accessor: &Accessor,
    vertex_count: usize,
    budget: &mut Budget,
) -> Result<Vec<u32>> {
    let restart = match (accessor.dimensions, accessor.component, accessor.normalized) {
        (Dimensions::Scalar, DataType::U8, false) => u32::from(u8::MAX),
        (Dimensions::Scalar, DataType::U16, false) => u32::from(u16::MAX),
        (Dimensions::Scalar, DataType::U32, false) => u32::MAX,
        _ => return Err(wrong_type(accessor, "indices", "Scalar of U8, U16 or U32, not normalized")),
    };
    let packed = store.packed(accessor, budget)?;
    let indices: Vec<u32> = packed.chunks_exact(accessor.component.size()).map(unsigned).collect();
    for (element, &index) in indices.iter().enumerate() {
        let rule = if index == restart {
            "the value that restarts a primitive, which glTF does not allow".to_owned()
        } else if index as usize >= vertex_count {
            format!("the primitive has {vertex_count} vertices")
        } else {
            continue;
        };
        let detail = format!("index {element} is {index}: {rule}");
        return Err(Error::invalid(detail).at(accessor.pointer.clone()));
    }
    Ok(indices)
}
