//! The numbers of a PLY file one after the other, however they are written.

use super::super::text::quoted_bytes;
use super::header::{Element, Encoding, Kind};
use crate::error::{Error, Result};

/// Bytes of the longest number that makes sense to write.
const NUMBER_BYTES: usize = 128;

pub struct Values<'a> {
    rest: &'a [u8],
    encoding: Encoding,
}

impl<'a> Values<'a> {
    pub fn new(body: &'a [u8], encoding: Encoding) -> Self {
        Self { rest: body, encoding }
    }

    /// Whether what is left can hold all of an element, as far as its header tells: each list is empty at least. Checked before
    /// memory is taken for any.
    pub fn check_room(&self, element: &Element) -> Result<()> {
        let least = |kind: Kind| match self.encoding {
            Encoding::Ascii => 2,
            _ => kind.byte_count() as u64,
        };
        let each: u64 =
            element.properties.iter().map(|property| least(property.length.unwrap_or(property.kind))).sum();
        let needed = element.count.saturating_mul(each);
        // The last number of a text needs no space behind it.
        let left = self.rest.len() as u64 + u64::from(self.encoding == Encoding::Ascii);
        if needed <= left {
            return Ok(());
        }
        Err(Error::invalid(format!(
            "the header announces {} elements {}, which take {needed} bytes at least; the file has {left} left",
            element.count,
            quoted_bytes(&element.name)
        )))
    }

    pub fn number(&mut self, kind: Kind) -> Result<f64> {
        match self.encoding {
            Encoding::Ascii => self.word(kind),
            Encoding::Little => Ok(number_of(self.take(kind.byte_count())?, kind)),
            Encoding::Big => {
                let stored = self.take(kind.byte_count())?;
                let mut bytes = [0; 8];
                bytes[..stored.len()].copy_from_slice(stored);
                bytes[..stored.len()].reverse();
                Ok(number_of(&bytes, kind))
            }
        }
    }

    /// How many numbers a list has, which the file is long enough for.
    pub fn length(&mut self, length: Kind, item: Kind) -> Result<usize> {
        let stored = self.number(length)?;
        let most = match self.encoding {
            Encoding::Ascii => self.rest.len().div_ceil(2),
            _ => self.rest.len() / item.byte_count(),
        };
        if stored >= 0.0 && stored.fract() == 0.0 && stored <= most as f64 {
            return Ok(stored as usize);
        }
        Err(Error::invalid(format!("a list of {stored} numbers, where the file has room for {most}")))
    }

    pub fn skip(&mut self, kind: Kind, count: usize) -> Result<()> {
        if self.encoding == Encoding::Ascii {
            return (0..count).try_for_each(|_| self.word(kind).map(drop));
        }
        self.take(count.saturating_mul(kind.byte_count())).map(drop)
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else { return Err(ended()) };
        self.rest = rest;
        Ok(taken)
    }

    /// A number that is written as text, in its kind's range.
    fn word(&mut self, kind: Kind) -> Result<f64> {
        let rest = self.rest.trim_ascii_start();
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        self.rest = rest;
        if word.is_empty() {
            return Err(ended());
        }
        let number = Some(word).filter(|word| word.len() <= NUMBER_BYTES);
        let number: Option<f64> = number.and_then(|word| str::from_utf8(word).ok()?.parse().ok());
        number.filter(|number| holds(kind, *number)).ok_or_else(|| {
            Error::invalid(format!("{} is not a number of the announced type", quoted_bytes(word)))
        })
    }
}

fn ended() -> Error {
    Error::invalid("the file ends before all that its header announces")
}

fn holds(kind: Kind, number: f64) -> bool {
    let (least, most) = match kind {
        Kind::I8 => (-128.0, 127.0),
        Kind::U8 => (0.0, 255.0),
        Kind::I16 => (-32_768.0, 32_767.0),
        Kind::U16 => (0.0, 65_535.0),
        Kind::I32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
        Kind::U32 => (0.0, f64::from(u32::MAX)),
        Kind::F32 | Kind::F64 => return true,
    };
    (least..=most).contains(&number) && number.fract() == 0.0
}

/// The number whose bytes, the lowest first, `bytes` begin with. There are enough of them.
fn number_of(bytes: &[u8], kind: Kind) -> f64 {
    match (kind, bytes) {
        (Kind::I8, &[a, ..]) => f64::from(a as i8),
        (Kind::U8, &[a, ..]) => f64::from(a),
        (Kind::I16, &[a, b, ..]) => f64::from(i16::from_le_bytes([a, b])),
        (Kind::U16, &[a, b, ..]) => f64::from(u16::from_le_bytes([a, b])),
        (Kind::I32, &[a, b, c, d, ..]) => f64::from(i32::from_le_bytes([a, b, c, d])),
        (Kind::U32, &[a, b, c, d, ..]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (Kind::F32, &[a, b, c, d, ..]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        (Kind::F64, &[a, b, c, d, e, f, g, h]) => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
        _ => f64::NAN,
    }
}
