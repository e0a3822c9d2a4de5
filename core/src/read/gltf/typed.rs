//! Packed elements to numbers: the vertex attributes and indices that the conversion computes with.

use ::gltf::accessor::{DataType, Dimensions};
use glam::{Vec2, Vec3, Vec4};

use super::super::budget::Budget;
use super::super::geometry::{POSITION_MAX, UV_MAX, check_finite};
use super::accessors::{Accessor, Store, unsigned};
use super::quantized::{Semantic, numbers};
use crate::error::{Error, Result};

fn wrong_type(accessor: &Accessor, semantic: &str, allowed: &str) -> Error {
    let detail = format!("{semantic} must be {allowed}, but the accessor is {}", accessor.describe());
    Error::invalid(detail).at(accessor.pointer.clone())
}

/// An attribute of floats or of codes that stand for some, all finite and within `max`.
fn float_vectors<const N: usize>(
    store: &Store,
    accessor: &Accessor,
    (name, semantic, max): (&str, Semantic, f32),
    budget: &mut Budget,
) -> Result<Vec<[f32; N]>> {
    if !semantic.allows(accessor, store.quantization) {
        return Err(wrong_type(accessor, name, &semantic.allowed(store.quantization)));
    }
    let packed = store.packed(accessor, budget)?;
    let vectors = numbers::<N>(&packed, accessor);
    check_vectors(&vectors, name, max, accessor)?;
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
    let vectors = float_vectors(store, accessor, ("POSITION", Semantic::Position, POSITION_MAX), budget)?;
    Ok(vectors.into_iter().map(Vec3::from_array).collect())
}

pub(super) fn normals(store: &Store, accessor: &Accessor, budget: &mut Budget) -> Result<Vec<Vec3>> {
    let vectors = float_vectors(store, accessor, ("NORMAL", Semantic::Normal, f32::MAX), budget)?;
    Ok(vectors.into_iter().map(Vec3::from_array).collect())
}

pub(super) fn tangents(store: &Store, accessor: &Accessor, budget: &mut Budget) -> Result<Vec<Vec4>> {
    let vectors = float_vectors(store, accessor, ("TANGENT", Semantic::Tangent, f32::MAX), budget)?;
    Ok(vectors.into_iter().map(Vec4::from_array).collect())
}

pub(super) fn texcoords(
    store: &Store,
    accessor: &Accessor,
    semantic: &str,
    budget: &mut Budget,
) -> Result<Vec<Vec2>> {
    let vectors = float_vectors(store, accessor, (semantic, Semantic::Texcoord, UV_MAX), budget)?;
    Ok(vectors.into_iter().map(Vec2::from_array).collect())
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
    let numbers: Vec<f32> = numbers::<1>(&packed, accessor).into_iter().flatten().collect();
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
