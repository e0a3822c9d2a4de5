//! The header of a PLY file: how numbers are written, which elements follow, and what each consists of.

use super::super::text::quoted_bytes;
use crate::error::{Error, ErrorCode, Result};

/// A header is some hundred bytes; comments may make it longer.
const HEADER_BYTES_MAX: usize = 1 << 20;
const ELEMENTS_MAX: usize = 64;
/// Of one element.
const PROPERTIES_MAX: usize = 256;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Ascii,
    Little,
    Big,
}

/// How one number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Property {
    pub name: Vec<u8>,
    pub kind: Kind,
    /// Of a list: how its length is stored.
    pub length: Option<Kind>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Element {
    pub name: Vec<u8>,
    pub count: u64,
    pub properties: Vec<Property>,
}

#[derive(Debug)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// What follows `comment TextureFile`, with the line.
    pub textures: Vec<(Vec<u8>, usize)>,
    /// Where the first element begins, bytes.
    pub body: usize,
}

impl Kind {
    fn of(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    pub fn byte_count(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

impl Element {
    /// The place of a property that is no list, by the first of its names.
    pub fn scalar(&self, names: &[&str]) -> Option<usize> {
        self.find(names, false)
    }

    pub fn list(&self, names: &[&str]) -> Option<usize> {
        self.find(names, true)
    }

    fn find(&self, names: &[&str], is_list: bool) -> Option<usize> {
        let is = |property: &Property, name: &str| {
            property.name == name.as_bytes() && property.length.is_some() == is_list
        };
        names.iter().find_map(|name| self.properties.iter().position(|property| is(property, name)))
    }
}

/// # Errors
/// `InvalidModel` with `file:line`.
pub fn parse(bytes: &[u8], file: &str) -> Result<Header> {
    let mut lines = HeaderLines::new(bytes);
    let mut header =
        Header { encoding: Encoding::Ascii, elements: Vec::new(), textures: Vec::new(), body: 0 };
    let mut has_format = false;
    while let Some(line) = lines.next_line() {
        let number = lines.number;
        let at = |error: Error| error.at(format!("{file}:{number}"));
        let (word, rest) = split(line);
        match word {
            b"ply" | b"obj_info" | b"" => {}
            b"comment" => {
                if let (b"TextureFile", name) = split(rest) {
                    header.textures.push((name.to_vec(), number));
                }
            }
            b"format" => {
                header.encoding = encoding(rest).map_err(at)?;
                has_format = true;
            }
            b"element" => {
                if header.elements.len() == ELEMENTS_MAX {
                    return Err(at(Error::invalid(format!("more than {ELEMENTS_MAX} elements"))));
                }
                header.elements.push(element(rest).map_err(at)?);
            }
            b"property" => {
                let property = property(rest).map_err(at)?;
                let Some(element) = header.elements.last_mut() else {
                    return Err(at(Error::invalid("a property stands before the first element")));
                };
                if element.properties.len() == PROPERTIES_MAX {
                    return Err(at(Error::invalid(format!(
                        "an element has more than {PROPERTIES_MAX} properties"
                    ))));
                }
                element.properties.push(property);
            }
            b"end_header" if has_format => {
                header.body = lines.at;
                return Ok(header);
            }
            b"end_header" => return Err(at(Error::invalid("`format` is missing"))),
            _ => {
                let detail = format!("the header has no line {}", quoted_bytes(line));
                return Err(at(Error::invalid(detail)));
            }
        }
    }
    let detail = format!("the header has no `end_header` within its first {HEADER_BYTES_MAX} bytes");
    Err(Error::invalid(detail).at(file))
}

fn encoding(rest: &[u8]) -> Result<Encoding> {
    match rest {
        b"ascii 1.0" => Ok(Encoding::Ascii),
        b"binary_little_endian 1.0" => Ok(Encoding::Little),
        b"binary_big_endian 1.0" => Ok(Encoding::Big),
        _ => Err(Error::new(
            ErrorCode::UnsupportedMediaType,
            format!(
                "the format {} is none of ascii, binary_little_endian and binary_big_endian 1.0",
                quoted_bytes(rest)
            ),
        )),
    }
}

fn element(rest: &[u8]) -> Result<Element> {
    let (name, count) = split(rest);
    let count = str::from_utf8(count).ok().and_then(|digits| digits.parse().ok());
    match count {
        Some(count) if !name.is_empty() => Ok(Element { name: name.to_vec(), count, properties: Vec::new() }),
        _ => Err(Error::invalid("an element is `element NAME COUNT`")),
    }
}

fn property(rest: &[u8]) -> Result<Property> {
    let wrong = || {
        Error::invalid(format!(
            "the property {} is neither `TYPE NAME` nor `list COUNT TYPE NAME`; a TYPE is char, uchar, short, ushort, int, uint, \
             float, double or one of int8 to float64, a COUNT a whole one of these",
            quoted_bytes(rest)
        ))
    };
    let (first, after) = split(rest);
    let (length, kind, name) = if first == b"list" {
        let (length, after) = split(after);
        let (kind, name) = split(after);
        (Some(Kind::of(length).filter(|kind| kind.is_whole()).ok_or_else(wrong)?), kind, name)
    } else {
        (None, first, after)
    };
    let kind = Kind::of(kind).ok_or_else(wrong)?;
    if name.is_empty() { Err(wrong()) } else { Ok(Property { name: name.to_vec(), kind, length }) }
}

/// The first word and what follows it.
fn split(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii();
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    (&line[..end], line[end..].trim_ascii())
}

/// Lines of the header. They end as the first one does: a body of bytes may begin with what looks like the other half
/// of a line end.
struct HeaderLines<'a> {
    bytes: &'a [u8],
    at: usize,
    end: u8,
    /// Of the line that came last, from 1.
    number: usize,
}

impl<'a> HeaderLines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let head = &bytes[..bytes.len().min(HEADER_BYTES_MAX)];
        let is_old_mac = head.starts_with(b"ply\r") && !head.starts_with(b"ply\r\n");
        Self { bytes: head, at: 0, end: if is_old_mac { b'\r' } else { b'\n' }, number: 0 }
    }

    /// `None` where no further line is complete.
    fn next_line(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&byte| byte == self.end)?;
        self.at += length + 1;
        self.number += 1;
        Some(&rest[..length])
    }
}
