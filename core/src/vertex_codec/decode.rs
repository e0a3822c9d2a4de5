//! meshoptimizer's decoders. They trust sizes, so these are all checked here, against the rules of the extension and
//! against the bytes that are there.

use std::ffi::c_void;

use meshopt::ffi;

use super::{Filter, Form, Mode};

/// A view that the decoders can be given: its stride suits mode and filter, and it is not shorter than any packed
/// view of as many elements.
#[derive(Clone, Copy, Debug)]
pub struct Checked<'a> {
    form: Form,
    packed: &'a [u8],
    bytes: usize,
}

impl<'a> Checked<'a> {
    /// # Errors
    /// What is wrong, in words.
    pub fn new(form: Form, packed: &'a [u8]) -> Result<Self, String> {
        let Form { mode, filter, count, stride } = form;
        let (strides, suits, first, version) = match mode {
            Mode::Attributes => (
                "a multiple of 4 in 4..=256",
                stride.is_multiple_of(4) && (4..=256).contains(&stride),
                0xA0,
                0,
            ),
            Mode::Triangles => ("2 or 4", matches!(stride, 2 | 4), 0xE1, 1),
            Mode::Indices => ("2 or 4", matches!(stride, 2 | 4), 0xD1, 1),
        };
        if !suits {
            return Err(format!("byteStride is {stride}; of mode {mode:?} it is {strides}"));
        }
        let (strides, suits) = match filter {
            Filter::None => ("any", true),
            Filter::Octahedral => ("4 or 8", matches!(stride, 4 | 8)),
            Filter::Quaternion => ("8", stride == 8),
            Filter::Exponential => ("a multiple of 4", stride.is_multiple_of(4)),
        };
        if filter != Filter::None && mode != Mode::Attributes {
            return Err(format!("filter {filter:?} is for mode Attributes, the mode is {mode:?}"));
        }
        if !suits {
            return Err(format!("byteStride is {stride}; of filter {filter:?} it is {strides}"));
        }
        if count == 0 || (mode == Mode::Triangles && !count.is_multiple_of(3)) {
            return Err(format!("count is {count}; it is at least 1, of mode Triangles a multiple of 3"));
        }
        let least = least_bytes(form);
        if packed.len() < least {
            let actual = packed.len();
            return Err(format!(
                "{count} elements are packed in no less than {least} bytes, here are {actual}"
            ));
        }
        if packed[0] != first {
            return Err(format!(
                "the packed bytes begin with {:#04x}; of mode {mode:?} they begin with {first:#04x} (version {version})",
                packed[0]
            ));
        }
        // The packed bytes bound the count, so this holds; the decoders rest on it.
        let bytes = count.checked_mul(stride).filter(|bytes| *bytes <= isize::MAX as usize / 2);
        let bytes = bytes.ok_or_else(|| format!("{count} elements of {stride} bytes are too many"))?;
        Ok(Self { form, packed, bytes })
    }

    /// Bytes of the unpacked view.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// # Errors
    /// What is wrong with the packed bytes, in words.
    pub fn unpack(&self) -> Result<Vec<u8>, String> {
        let Form { mode, filter, count, stride } = self.form;
        let (source, length) = (self.packed.as_ptr(), self.packed.len());
        // Words of eight bytes: the decoders write numbers of up to four bytes and need their alignment.
        let mut words = vec![0u64; self.bytes.div_ceil(8)];
        let target = words.as_mut_ptr().cast::<c_void>();
        // SAFETY: `target` has count * stride bytes (`bytes`, computed without overflow), all initialized and aligned
        // to 8; `source` has `length` bytes, no fewer than the format's least for `count`. The stride is one that the
        // decoder of the mode takes, and the count of triangles' indices is a multiple of 3. The decoders do not read or
        // write outside of these ranges whatever the packed bytes are, and keep no pointer.
        let code = unsafe {
            match mode {
                Mode::Attributes => ffi::meshopt_decodeVertexBuffer(target, count, stride, source, length),
                Mode::Triangles => ffi::meshopt_decodeIndexBuffer(target, count, stride, source, length),
                Mode::Indices => ffi::meshopt_decodeIndexSequence(target, count, stride, source, length),
            }
        };
        if code != 0 {
            let what = match code {
                -1 => "they are of another form",
                -2 => "they end too early or say what cannot be",
                _ => "their length is not that of so many elements",
            };
            return Err(format!("the packed bytes cannot be read as mode {mode:?}: {what}"));
        }
        // SAFETY: `target` is as above; the stride is one that the filter takes, and filters come with attributes alone.
        unsafe {
            match filter {
                Filter::None => {}
                Filter::Octahedral => ffi::meshopt_decodeFilterOct(target, count, stride),
                Filter::Quaternion => ffi::meshopt_decodeFilterQuat(target, count, stride),
                Filter::Exponential => ffi::meshopt_decodeFilterExp(target, count, stride),
            }
        }
        let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_ne_bytes()).collect();
        bytes.truncate(self.bytes);
        Ok(bytes)
    }
}

/// The shortest packed form of so many elements: a file's count is held against it before memory is taken, so at
/// most 64 bytes are made of one.
fn least_bytes(form: Form) -> usize {
    let Form { mode, count, stride, .. } = form;
    match mode {
        // First byte, two bits for each byte of sixteen elements, the tail.
        Mode::Attributes => {
            count.div_ceil(64).saturating_mul(stride).saturating_add(1).saturating_add(stride.max(32))
        }
        // First byte, one byte for each triangle, a table.
        Mode::Triangles => (count / 3).saturating_add(1 + 16),
        // First byte, at least one byte for each index, the tail.
        Mode::Indices => count.saturating_add(1 + 4),
    }
}
