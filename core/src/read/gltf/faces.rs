//! Triangles of a primitive: lists, strips and fans unrolled as glTF 2.0, section 3.7.2.1 has it.

use super::super::budget::Budget;
use crate::asset::Face;
use crate::error::{Error, Result};

/// How the vertices of a primitive connect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// Points and lines of any kind: nothing with a surface.
    NoFaces {
        least: usize,
        multiple: usize,
    },
    Triangles,
    Strip,
    Fan,
}

impl Mode {
    pub fn from_code(code: usize) -> Option<Self> {
        Some(match code {
            0 => Mode::NoFaces { least: 1, multiple: 1 },
            1 => Mode::NoFaces { least: 2, multiple: 2 },
            2 | 3 => Mode::NoFaces { least: 2, multiple: 1 },
            4 => Mode::Triangles,
            5 => Mode::Strip,
            6 => Mode::Fan,
            _ => return None,
        })
    }
}

/// `corners` are the vertex numbers in drawing order, the indices or simply all vertices; there are
/// `count` of them.
pub(super) fn unroll(
    mode: Mode,
    count: usize,
    corner: impl Fn(usize) -> u32,
    pointer: &str,
    budget: &mut Budget,
) -> Result<Vec<Face>> {
    let (least, multiple) = match mode {
        Mode::NoFaces { least, multiple } => (least, multiple),
        Mode::Triangles => (3, 3),
        Mode::Strip | Mode::Fan => (3, 1),
    };
    if count < least || !count.is_multiple_of(multiple) {
        let detail = format!("{count} corners do not make up primitives of this mode");
        return Err(Error::invalid(detail).at(pointer));
    }
    let triangle_count = match mode {
        Mode::NoFaces { .. } => 0,
        Mode::Triangles => count / 3,
        Mode::Strip | Mode::Fan => count - 2,
    };
    budget.take_triangles(triangle_count as u64, pointer)?;
    let triangle = |i: usize| {
        let [a, b, c] = match mode {
            Mode::Triangles => [3 * i, 3 * i + 1, 3 * i + 2],
            // Every second triangle of a strip is drawn the other way round.
            Mode::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Mode::Fan | Mode::NoFaces { .. } => [i + 1, i + 2, 0],
        };
        Face::triangle([corner(a), corner(b), corner(c)])
    };
    Ok((0..triangle_count).map(triangle).collect())
}
