//! Lines of OBJ and MTL files: any line end, `\` before the end joins two lines.

use std::borrow::Cow;

/// Yields the number of a line (from 1; of joined lines, the first) and its bytes without surrounding
/// white space. Empty lines and comments are left out.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    pub fn new(text: &'a [u8]) -> Self {
        Self { rest: text, number: 0 }
    }

    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest.strip_prefix(b"\r\n").or_else(|| rest.get(1..)).unwrap_or_default();
        self.number += 1;
        Some(line)
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let line = self.physical()?.trim_ascii();
            let number = self.number;
            if line.is_empty() || line[0] == b'#' {
                continue;
            }
            let Some(head) = line.strip_suffix(b"\\") else {
                return Some((number, Cow::Borrowed(line)));
            };
            let mut joined = head.to_vec();
            while let Some(more) = self.physical() {
                let more = more.trim_ascii();
                joined.push(b' ');
                match more.strip_suffix(b"\\") {
                    Some(more) => joined.extend_from_slice(more),
                    None => {
                        joined.extend_from_slice(more);
                        break;
                    }
                }
            }
            return Some((number, Cow::Owned(joined)));
        }
    }
}

/// The first word and what follows it.
pub(super) fn split_word(line: &[u8]) -> (&[u8], &[u8]) {
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    (&line[..end], line[end..].trim_ascii())
}

/// Words up to a comment.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
        .take_while(|word| !word.starts_with(b"#"))
}

/// Bytes of the longest number that makes sense to write.
const NUMBER_BYTES: usize = 128;

/// A finite number in single precision.
pub(super) fn number(word: &[u8]) -> Option<f32> {
    if word.len() > NUMBER_BYTES {
        return None;
    }
    str::from_utf8(word).ok()?.parse().ok().filter(|number: &f32| number.is_finite())
}
