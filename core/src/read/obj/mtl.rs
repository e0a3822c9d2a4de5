//! MTL files: the materials that an OBJ file names. Nothing is opened here.

use glam::{Vec2, Vec3};

use super::super::text::quoted_bytes;
use super::super::warnings::Warnings;
use super::lines::{Lines, number, split_word, words};
use crate::asset::UvTransform;
use crate::error::{Error, Result};

/// A texture of a material: its file and how it is laid on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    pub file: Vec<u8>,
    /// `file:line`, for errors about the image.
    pub place: String,
    /// In glTF's convention: v downwards.
    pub transform: UvTransform,
    pub clamp: bool,
    pub bump_multiplier: f32,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Definition {
    pub name: Vec<u8>,
    pub diffuse: Option<Vec3>,
    pub opacity: Option<f32>,
    pub emission: Option<Vec3>,
    pub roughness: Option<f32>,
    pub metallic: Option<f32>,
    pub diffuse_map: Option<Map>,
    pub emission_map: Option<Map>,
    pub normal_map: Option<Map>,
}

impl Definition {
    pub fn maps(&self) -> impl Iterator<Item = &Map> {
        [&self.diffuse_map, &self.emission_map, &self.normal_map].into_iter().flatten()
    }
}

/// Largest scale or offset of a map: what keeps texel numbers within their type.
const TRANSFORM_MAX: f32 = 1e6;

pub(super) fn parse(text: &[u8], file: &str, warnings: &mut Warnings) -> Result<Vec<Definition>> {
    let mut definitions: Vec<Definition> = Vec::new();
    for (line, statement) in Lines::new(text) {
        let place = format!("{file}:{line}");
        let (word, rest) = split_word(&statement);
        if word.eq_ignore_ascii_case(b"newmtl") {
            definitions.push(Definition { name: rest.to_vec(), ..Definition::default() });
            continue;
        }
        let Some(current) = definitions.last_mut() else {
            return Err(Error::invalid("a statement stands before the first `newmtl`").at(place));
        };
        statement_of(current, &word.to_ascii_lowercase(), rest, &place, warnings)
            .map_err(|error| error.at(place))?;
    }
    Ok(definitions)
}

fn statement_of(
    current: &mut Definition,
    word: &[u8],
    rest: &[u8],
    place: &str,
    warnings: &mut Warnings,
) -> Result<()> {
    match word {
        b"kd" => current.diffuse = color(rest, place, warnings)?,
        b"ke" => current.emission = color(rest, place, warnings)?,
        b"d" => current.opacity = Some(share(rest)?),
        b"tr" => current.opacity = Some(1.0 - share(rest)?),
        b"pr" => current.roughness = Some(share(rest)?),
        b"pm" => current.metallic = Some(share(rest)?),
        b"map_kd" => current.diffuse_map = Some(map(rest, place)?),
        b"map_ke" => current.emission_map = Some(map(rest, place)?),
        b"norm" => current.normal_map = Some(map(rest, place)?),
        b"bump" | b"disp" | b"decal" | b"refl" => ignore_map(place, warnings),
        _ if word.starts_with(b"map_") => ignore_map(place, warnings),
        // Of lighting models that glTF does not have.
        b"ka" | b"ks" | b"ns" | b"ni" | b"tf" | b"illum" | b"sharpness" => {}
        _ => {
            let detail = "statements that are not read; they are ignored";
            warnings.add("ignored_statement", place, detail);
        }
    }
    Ok(())
}

fn ignore_map(place: &str, warnings: &mut Warnings) {
    let detail = "texture maps other than map_Kd, map_Ke and norm; they are left out";
    warnings.add("ignored_map", place, detail);
}

fn value(word: &[u8]) -> Result<f32> {
    number(word).ok_or_else(|| Error::invalid(format!("{} is not a finite number", quoted_bytes(word))))
}

/// One number or three. Spectral files and CIE colors, which nobody writes, are `None`.
fn color(rest: &[u8], place: &str, warnings: &mut Warnings) -> Result<Option<Vec3>> {
    if rest.starts_with(b"spectral") || rest.starts_with(b"xyz") {
        let detail = "colors given as spectrum or CIE XYZ; they are left out";
        warnings.add("ignored_color", place, detail);
        return Ok(None);
    }
    let numbers = words(rest).map(value).collect::<Result<Vec<f32>>>()?;
    let color = match numbers[..] {
        [gray] => Vec3::splat(gray),
        [red, green, blue] => Vec3::new(red, green, blue),
        _ => return Err(Error::invalid(format!("a color has 1 or 3 numbers, not {}", numbers.len()))),
    };
    let within = color.clamp(Vec3::ZERO, Vec3::ONE);
    if within != color {
        let detail = "colors beyond 0 to 1; they were clamped";
        warnings.add("clamped_color", place, detail);
    }
    Ok(Some(within))
}

/// The first number (`d -halo 0.5` has a word before it, and some files go on behind it), held to 0..=1.
fn share(rest: &[u8]) -> Result<f32> {
    let word = words(rest).find(|word| *word != b"-halo");
    match word {
        Some(word) => Ok(value(word)?.clamp(0.0, 1.0)),
        None => Err(Error::invalid("the number is missing")),
    }
}

/// Options, then the file's name, which may hold spaces.
fn map(rest: &[u8], place: &str) -> Result<Map> {
    let mut scale = Vec2::ONE;
    let mut offset = Vec2::ZERO;
    let (mut clamp, mut bump_multiplier) = (false, 1.0);
    let mut left = rest;
    while left.starts_with(b"-") {
        let (option, after) = split_word(left);
        let (numbers, after_numbers) = leading_numbers(after);
        let (word, after_word) = split_word(after);
        left = match &option.to_ascii_lowercase()[..] {
            b"-s" | b"-o" | b"-t" => {
                let default = if option.eq_ignore_ascii_case(b"-s") { 1.0 } else { 0.0 };
                let component = |i: usize| numbers.get(i).copied().unwrap_or(default);
                let pair = Vec2::new(component(0), component(1));
                if numbers.is_empty() || pair.abs().max_element() > TRANSFORM_MAX {
                    let detail = format!(
                        "{} needs one to three numbers within ±{TRANSFORM_MAX:e}",
                        quoted_bytes(option)
                    );
                    return Err(Error::invalid(detail));
                }
                match &option.to_ascii_lowercase()[..] {
                    b"-s" => scale = pair,
                    b"-o" => offset = pair,
                    // Turbulence distorts procedural textures alone.
                    _ => {}
                }
                after_numbers
            }
            b"-mm" => split_word(after_word).1,
            b"-clamp" => {
                clamp = word.eq_ignore_ascii_case(b"on");
                after_word
            }
            b"-bm" => {
                bump_multiplier = value(word)?;
                after_word
            }
            b"-blendu" | b"-blendv" | b"-cc" | b"-boost" | b"-texres" | b"-imfchan" | b"-type" => after_word,
            _ => {
                return Err(Error::invalid(format!(
                    "{} is no option of a texture map",
                    quoted_bytes(option)
                )));
            }
        };
    }
    if left.is_empty() {
        return Err(Error::invalid("the texture map names no file"));
    }
    // MTL: uv' = offset + scale uv with v upwards; here v runs downwards on both sides.
    let offset = Vec2::new(offset.x, 1.0 - offset.y - scale.y);
    let transform = UvTransform { offset, rotation: 0.0, scale };
    Ok(Map { file: left.to_vec(), place: place.to_owned(), transform, clamp, bump_multiplier })
}

/// Up to three numbers, always leaving a word for the file's name.
fn leading_numbers(rest: &[u8]) -> (Vec<f32>, &[u8]) {
    let mut numbers = Vec::new();
    let mut left = rest;
    while numbers.len() < 3 {
        let (word, after) = split_word(left);
        match number(word) {
            Some(number) if !after.is_empty() => numbers.push(number),
            _ => break,
        }
        left = after;
    }
    (numbers, left)
}
