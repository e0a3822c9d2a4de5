//! The statements of an OBJ file to flat lists, in one pass over its lines.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use super::super::Context;
use super::super::geometry::{POSITION_MAX, UV_MAX};
use super::super::made_up::{Corner, NONE, Polygon, Soup};
use super::super::text::quoted_bytes;
use super::lines::{Lines, number, split_word, words};
use crate::error::{Error, ErrorCode, Result};
use crate::math::transfer::srgb_to_linear;
use crate::watch;

/// Lines between two looks at the watch.
const WATCH_LINES: usize = 1 << 16;

/// Polygons have the numbers of their lines.
#[derive(Debug, Default)]
pub(super) struct Parsed {
    pub soup: Soup,
    pub objects: Names,
    pub materials: Names,
    /// What follows `mtllib`, with the line.
    pub libraries: Vec<(Vec<u8>, usize)>,
}

const CLAMPED_COLOR: &str = "vertex colors outside of [0, 1]; the nearest in it were taken, so those of 0 to 255 are to be divided by 255";
const ALPHA: &str = "vertices with a 7th number, which behind x y z r g b is alpha; it was left out";

/// Names by number of first use.
#[derive(Debug, Default)]
pub(super) struct Names {
    pub list: Vec<Vec<u8>>,
    numbers: HashMap<Vec<u8>, usize>,
}

impl Names {
    pub(super) fn number(&mut self, name: &[u8]) -> usize {
        if let Some(&number) = self.numbers.get(name) {
            return number;
        }
        let number = self.list.len();
        self.list.push(name.to_vec());
        self.numbers.insert(name.to_vec(), number);
        number
    }
}

pub(super) fn parse(text: &[u8], file: &str, context: &mut Context) -> Result<Parsed> {
    let soup = Soup { file: file.to_owned(), separator: ":", ..Soup::default() };
    let parsed = Parsed { soup, ..Parsed::default() };
    let mut parser = Parser { parsed, object: None, material: NONE, context };
    for (count, (line, statement)) in Lines::new(text).enumerate() {
        if count % WATCH_LINES == 0 {
            watch::check(parser.context.watch)?;
        }
        parser.statement(&statement, line, file).map_err(|error| error.at(format!("{file}:{line}")))?;
    }
    let parsed = parser.parsed;
    check_ranges(&parsed.soup)?;
    if parsed.soup.polygons.is_empty() {
        return Err(Error::new(ErrorCode::NothingToConvert, "the OBJ file has no faces").at(file));
    }
    Ok(parsed)
}

struct Parser<'p, 'c> {
    parsed: Parsed,
    object: Option<usize>,
    material: u32,
    context: &'p mut Context<'c>,
}

impl Parser<'_, '_> {
    fn statement(&mut self, statement: &[u8], line: usize, file: &str) -> Result<()> {
        let (word, rest) = split_word(statement);
        match word {
            b"v" => self.vertex(rest, &|| format!("{file}:{line}")),
            b"vt" => self.texcoord(rest),
            b"vn" => self.normal(rest),
            b"f" | b"fo" => self.face(rest, line),
            b"o" => {
                self.object = Some(self.parsed.objects.number(rest));
                Ok(())
            }
            b"usemtl" => {
                self.material = self.parsed.materials.number(rest) as u32;
                Ok(())
            }
            b"mtllib" => {
                self.parsed.libraries.push((rest.to_vec(), line));
                Ok(())
            }
            // Groups and smoothing groups say nothing about shape or color.
            b"g" | b"s" => Ok(()),
            _ => {
                let detail = "statements that are not read; they are ignored";
                self.context.warnings.add("ignored_statement", &format!("{file}:{line}"), detail);
                Ok(())
            }
        }
    }

    fn vertex(&mut self, rest: &[u8], place: &dyn Fn() -> String) -> Result<()> {
        let (numbers, count) = numbers::<7>(rest, POSITION_MAX)?;
        let color = match count {
            // With a weight, which only free-form curves use.
            3 | 4 => None,
            // With an alpha, which OBJ readers leave out.
            6 | 7 => Some([numbers[3], numbers[4], numbers[5]]),
            _ => {
                let detail = format!(
                    "`v` has {count} numbers; allowed are x y z, x y z w, x y z r g b and x y z r g b a"
                );
                return Err(Error::invalid(detail));
            }
        };
        let parsed = &mut self.parsed.soup;
        check_count(parsed.positions.len(), self.context.budget.limits.vertices, "v")?;
        if let Some(color) = color
            && parsed.colors.len() == parsed.positions.len()
        {
            let is_bounded = color.iter().all(|value| (0.0..=1.0).contains(value));
            for (code, detail, is_so) in [
                ("clamped_color", CLAMPED_COLOR, !is_bounded),
                ("ignored_alpha", ALPHA, count == 7 && numbers[6] != 1.0),
            ] {
                if is_so {
                    self.context.warnings.add(code, &place(), detail);
                }
            }
            let color = color.map(|value| value.clamp(0.0, 1.0));
            // Painting tools store what they show, glTF's COLOR_0 is linear.
            parsed.colors.push(Vec3::from_array(color.map(srgb_to_linear)).extend(1.0));
        }
        parsed.positions.push(Vec3::new(numbers[0], numbers[1], numbers[2]));
        Ok(())
    }

    fn texcoord(&mut self, rest: &[u8]) -> Result<()> {
        let (numbers, count) = numbers::<3>(rest, UV_MAX)?;
        if count == 0 {
            return Err(Error::invalid("`vt` has no numbers"));
        }
        check_count(self.parsed.soup.texcoords.len(), self.context.budget.limits.vertices, "vt")?;
        self.parsed.soup.texcoords.push(Vec2::new(numbers[0], (1.0 - numbers[1]).clamp(-UV_MAX, UV_MAX)));
        Ok(())
    }

    fn normal(&mut self, rest: &[u8]) -> Result<()> {
        let (numbers, count) = numbers::<3>(rest, f32::MAX)?;
        if count != 3 {
            return Err(Error::invalid(format!("`vn` has {count} numbers; a normal has 3")));
        }
        check_count(self.parsed.soup.normals.len(), self.context.budget.limits.vertices, "vn")?;
        self.parsed.soup.normals.push(Vec3::from_array(numbers));
        Ok(())
    }

    fn face(&mut self, rest: &[u8], line: usize) -> Result<()> {
        let first = self.parsed.soup.corners.len();
        for (index, word) in words(rest).enumerate() {
            let corner = self.corner(word)?;
            // Each corner after the second makes a triangle, counted before it is stored.
            if index >= 2 {
                self.context.budget.take_triangles(1, "")?;
            }
            self.parsed.soup.corners.push(corner);
        }
        let count = self.parsed.soup.corners.len() - first;
        if count < 3 {
            return Err(Error::invalid(format!("the face has {count} corners; it needs at least 3")));
        }
        let object = match self.object {
            Some(object) => object,
            None => *self.object.insert(self.parsed.objects.number(b"")),
        };
        let polygon = Polygon { first, count, object, material: self.material, number: line };
        self.parsed.soup.polygons.push(polygon);
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, word: &[u8]) -> Result<Corner> {
        let mut parts = word.split(|&b| b == b'/');
        let wrong = || {
            Error::invalid(format!(
                "the face's corner {} is none of v, v/vt, v//vn, v/vt/vn",
                quoted_bytes(word)
            ))
        };
        let mut part = |length: usize, what: &str| match parts.next() {
            None | Some(b"") => Ok(NONE),
            Some(digits) => index(digits, length).ok_or_else(|| {
                Error::invalid(format!(
                    "the {what} index {} is out of range: {length} are known",
                    quoted_bytes(digits)
                ))
            }),
        };
        let corner = Corner {
            position: part(self.parsed.soup.positions.len(), "v")?,
            texcoord: part(self.parsed.soup.texcoords.len(), "vt")?,
            normal: part(self.parsed.soup.normals.len(), "vn")?,
        };
        if corner.position == NONE || parts.next().is_some() {
            return Err(wrong());
        }
        Ok(corner)
    }
}

/// Up to `N` numbers, each finite and within `max`; how many there are.
fn numbers<const N: usize>(rest: &[u8], max: f32) -> Result<([f32; N], usize)> {
    let mut numbers = [0.0; N];
    let mut count = 0;
    for word in words(rest) {
        let Some(place) = numbers.get_mut(count) else {
            return Err(Error::invalid(format!("the statement has more than {N} numbers")));
        };
        *place = number(word).filter(|number| number.abs() <= max).ok_or_else(|| {
            Error::invalid(format!("{} is not a finite number within ±{max:e}", quoted_bytes(word)))
        })?;
        count += 1;
    }
    Ok((numbers, count))
}

fn check_count(count: usize, limit: u64, what: &str) -> Result<()> {
    let limit = limit.min(u64::from(NONE) - 1);
    if (count as u64) < limit {
        return Ok(());
    }
    let detail = format!("the model has more than {limit} `{what}` statements (limit `vertices`)");
    Err(Error::new(ErrorCode::ModelTooLarge, detail).limit(limit, count as u64 + 1))
}

/// Counted from 1, or backwards from the last one read. What lies ahead is allowed here and checked at
/// the end of the file.
fn index(digits: &[u8], length: usize) -> Option<u32> {
    let number: i64 = str::from_utf8(digits).ok()?.parse().ok()?;
    let index = match number {
        1.. => number - 1,
        0 => return None,
        _ => i64::try_from(length).ok()?.checked_add(number)?,
    };
    u32::try_from(index).ok().filter(|&index| index != NONE)
}

fn check_ranges(soup: &Soup) -> Result<()> {
    let lists = [soup.positions.len(), soup.texcoords.len(), soup.normals.len()];
    for polygon in &soup.polygons {
        for corner in soup.corners(polygon) {
            let indices = [corner.position, corner.texcoord, corner.normal];
            for ((index, length), what) in indices.into_iter().zip(lists).zip(["v", "vt", "vn"]) {
                if index != NONE && index as usize >= length {
                    let detail = format!(
                        "the {what} index {} is out of range: the file has {length}",
                        u64::from(index) + 1
                    );
                    return Err(Error::invalid(detail).at(soup.place(polygon)));
                }
            }
        }
    }
    Ok(())
}
