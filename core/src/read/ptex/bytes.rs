//! Pieces of a file, taken one after the other, and zlib streams of a known size.

use flate2::{Decompress, FlushDecompress, Status};

use super::super::Limits;
use crate::error::{Error, ErrorCode, Result};

/// A deflate stream holds at most 258 bytes in two bits (RFC 1951); with its own bytes that is under 1032 for one.
const RATIO_MAX: u64 = 1032;
/// What even an empty stream may be taken to unpack to.
const RATIO_FREE_BYTES: u64 = 1024;

/// Reads from the front; `what` names the block in errors.
pub struct Bytes<'a> {
    rest: &'a [u8],
    what: &'static str,
}

impl<'a> Bytes<'a> {
    pub fn new(rest: &'a [u8], what: &'static str) -> Self {
        Self { rest, what }
    }

    pub fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else {
            return Err(Error::invalid(format!("the file ends inside its {}", self.what)));
        };
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        Ok(bytes)
    }

    pub fn u8(&mut self) -> Result<u8> {
        self.array::<1>().map(|[byte]| byte)
    }

    pub fn u16(&mut self) -> Result<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub fn u32(&mut self) -> Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Result<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }
}

/// Cuts `bytes` off the front of `rest`.
pub fn block<'a>(rest: &mut &'a [u8], bytes: u64, what: &str) -> Result<&'a [u8]> {
    let split = usize::try_from(bytes).ok().and_then(|bytes| rest.split_at_checked(bytes));
    let Some((taken, behind)) = split else {
        let detail = format!("the {what} takes {bytes} bytes, of which the file has {}", rest.len());
        return Err(Error::invalid(detail));
    };
    *rest = behind;
    Ok(taken)
}

/// Unpacks a zlib stream of exactly `bytes`; what deflate cannot hold in `packed` is refused before memory is taken.
pub fn inflate(packed: &[u8], bytes: u64, what: &str, limits: &Limits) -> Result<Vec<u8>> {
    let limit = limits.archive_bytes;
    if bytes > limit {
        let detail =
            format!("the {what} unpacks to {bytes} bytes; the limit is {limit} (limit `archive_bytes`)");
        return Err(Error::new(ErrorCode::ModelTooLarge, detail).limit(limit, bytes));
    }
    let wrong = |had: &str| Error::invalid(format!("the {what} does not unpack to {bytes} bytes: {had}"));
    if bytes > RATIO_FREE_BYTES.max(RATIO_MAX.saturating_mul(packed.len() as u64)) {
        return Err(wrong(&format!("it has only {} packed", packed.len())));
    }
    let mut unpacked = vec![0; bytes as usize];
    let mut stream = Decompress::new(true);
    let status = stream.decompress(packed, &mut unpacked, FlushDecompress::Finish);
    match status {
        Ok(Status::StreamEnd) if stream.total_out() == bytes => Ok(unpacked),
        Ok(Status::StreamEnd) => Err(wrong(&format!("it ends after {}", stream.total_out()))),
        Ok(_) if stream.total_out() == bytes => Err(wrong("it has more")),
        Ok(_) => Err(wrong("it is cut short")),
        Err(error) => Err(wrong(&error.to_string())),
    }
}
