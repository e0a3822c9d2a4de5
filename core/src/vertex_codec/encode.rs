//! meshoptimizer's encoders, in the versions that the extension knows.

use std::ffi::c_void;

use meshopt::ffi;

/// Of the vertex codec; the extension has no other.
const VERSION: i32 = 0;
/// The most thorough one of that version.
const LEVEL: i32 = 2;

/// Elements of `stride` bytes: a multiple of 4, 256 at most. `None` where the stride is another, or `bytes` are not whole
/// elements.
pub fn packed_attributes(bytes: &[u8], stride: usize) -> Option<Vec<u8>> {
    if !stride.is_multiple_of(4) || !(4..=256).contains(&stride) || !bytes.len().is_multiple_of(stride) {
        return None;
    }
    let count = bytes.len() / stride;
    // SAFETY: `bytes` has `count` elements of `stride` bytes, which is a stride that the encoder takes; `packed` has as
    // many bytes as it asks for, and it writes no more than it is told that there are.
    let packed = unsafe {
        let mut packed = vec![0; ffi::meshopt_encodeVertexBufferBound(count, stride)];
        let (target, elements) = (packed.as_mut_ptr(), bytes.as_ptr().cast::<c_void>());
        let length = ffi::meshopt_encodeVertexBufferLevel(
            target,
            packed.len(),
            elements,
            count,
            stride,
            LEVEL,
            VERSION,
        );
        packed.truncate(length);
        packed
    };
    (!packed.is_empty()).then_some(packed)
}

/// Indices in their order (mode `Indices`: the codec for triangles may turn them).
pub fn packed_indices(indices: &[u32]) -> Option<Vec<u8>> {
    let vertex_count = indices.iter().max().map_or(0, |most| *most as usize + 1);
    // SAFETY: `packed` has as many bytes as the encoder asks for indices below `vertex_count`, and it writes no more than
    // it is told that there are.
    let packed = unsafe {
        let mut packed = vec![0; ffi::meshopt_encodeIndexSequenceBound(indices.len(), vertex_count)];
        let target = packed.as_mut_ptr();
        let length = ffi::meshopt_encodeIndexSequence(target, packed.len(), indices.as_ptr(), indices.len());
        packed.truncate(length);
        packed
    };
    (!packed.is_empty()).then_some(packed)
}

/// Floats as the filter `Exponential` takes them: an exponent of 8 bits and a mantissa of `bits` (1 to 24), each by itself, so
/// that equal numbers stay equal. Elements have `stride` bytes; all numbers are finite. `None` where that is not so.
pub fn rounded(values: &[f32], stride: usize, bits: u8) -> Option<Vec<u8>> {
    let per_element = stride / 4;
    let fits = stride.is_multiple_of(4)
        && (4..=256).contains(&stride)
        && values.len().is_multiple_of(per_element)
        && (1..=24).contains(&bits)
        && values.iter().all(|value| value.is_finite());
    if !fits {
        return None;
    }
    let mut words = vec![0u32; values.len()];
    let mode = ffi::meshopt_EncodeExpMode_meshopt_EncodeExpSeparate;
    // SAFETY: both have as many words of four bytes as `count` elements of `stride` bytes are, and the stride and the bits are
    // ones that the encoder takes.
    unsafe {
        let (target, count) = (words.as_mut_ptr().cast::<c_void>(), values.len() / per_element);
        ffi::meshopt_encodeFilterExp(target, count, stride, i32::from(bits), values.as_ptr(), mode);
    }
    Some(words.iter().flat_map(|word| word.to_le_bytes()).collect())
}

#[cfg(test)]
mod tests {
    use super::super::{Checked, Filter, Form, Mode};
    use super::*;
    use crate::math::random::Random;

    fn unpacked(packed: &[u8], mode: Mode, filter: Filter, count: usize, stride: usize) -> Vec<u8> {
        Checked::new(Form { mode, filter, count, stride }, packed).unwrap().unpack().unwrap()
    }

    #[test]
    fn what_is_packed_is_there_again() {
        let mut random = Random(1);
        for stride in [4, 8, 12, 60, 256] {
            let bytes: Vec<u8> = (0..stride * 301).map(|_| random.below(7) as u8).collect();
            let packed = packed_attributes(&bytes, stride).unwrap();
            assert!(packed.len() < bytes.len());
            assert_eq!(unpacked(&packed, Mode::Attributes, Filter::None, 301, stride), bytes);
        }
        let indices: Vec<u32> = (0..900).map(|k| k / 3 + random.below(5)).collect();
        let packed = packed_indices(&indices).unwrap();
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        assert_eq!(unpacked(&packed, Mode::Indices, Filter::None, 900, 4), bytes);
        for stride in [0, 2, 6, 260] {
            assert_eq!(packed_attributes(&[0; 520], stride), None, "{stride}");
        }
        assert_eq!(packed_attributes(&[0; 10], 4), None);
    }

    #[test]
    fn rounded_numbers_are_as_near_as_their_bits_say() {
        let mut random = Random(2);
        let mut values: Vec<f32> = (0..300).map(|_| (random.unit() - 0.5) * 1000.0).collect();
        values.extend([0.0, 1.0, -1.0, 0.5, values[0], values[1]]);
        for bits in [8, 16, 20] {
            let packed = packed_attributes(&rounded(&values, 12, bits).unwrap(), 12).unwrap();
            let bytes = unpacked(&packed, Mode::Attributes, Filter::Exponential, 102, 12);
            let found: Vec<f32> =
                bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
            for (value, found) in values.iter().zip(&found) {
                assert!(
                    (value - found).abs() <= value.abs() * (1.0 - f32::from(bits)).exp2(),
                    "{value} {found}"
                );
            }
            assert_eq!(found[300..304], [0.0, 1.0, -1.0, 0.5]);
            assert_eq!(found[304..], found[..2]);
        }
        assert_eq!(rounded(&[f32::NAN], 4, 8), None);
        assert_eq!(rounded(&[1.0], 4, 25), None);
    }
}
