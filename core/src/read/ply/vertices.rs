//! The element `vertex`: positions, normals, colors and texture coordinates.

use glam::{Vec2, Vec3, Vec4};

use super::super::Context;
use super::super::geometry::{POSITION_MAX, UV_MAX};
use super::super::made_up::Soup;
use super::WATCH_ELEMENTS;
use super::header::{Element, Kind};
use super::values::Values;
use crate::error::{Error, ErrorCode, Result};
use crate::math::transfer::srgb_to_linear;
use crate::watch;

/// The names that each number of a vertex goes by, in the order of [`Row`].
const NAMES: [&[&str]; 12] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["red", "diffuse_red", "r"],
    &["green", "diffuse_green", "g"],
    &["blue", "diffuse_blue", "b"],
    &["alpha"],
    &["s", "u", "texture_u"],
    &["t", "v", "texture_v"],
];

/// Position, normal, color with alpha, texture coordinates.
type Row = [f64; NAMES.len()];

/// What a vertex has of all that.
struct Form {
    /// By property: its place in a row.
    places: Vec<Option<usize>>,
    has_normals: bool,
    /// What stands for 1, of red, green, blue and alpha.
    color_scale: Option<[f64; 4]>,
    has_alpha: bool,
    has_texcoords: bool,
}

/// Fills the soup's lists, each by number of the vertex or empty.
pub fn read(element: &Element, values: &mut Values, soup: &mut Soup, context: &mut Context) -> Result<()> {
    let file = soup.file.clone();
    let form = Form::of(element, &soup.file, context).map_err(|error| error.at(file.clone()))?;
    let limit = context.budget.limits.vertices.min(u64::from(u32::MAX) - 1);
    if element.count > limit {
        let detail =
            format!("the file has {} vertices; the limit is {limit} (limit `vertices`)", element.count);
        let error = Error::new(ErrorCode::ModelTooLarge, detail);
        return Err(error.at(file).limit(limit, element.count));
    }
    let mut clamped_count = 0;
    for number in 0..element.count {
        if number % WATCH_ELEMENTS == 0 {
            watch::check(context.watch)?;
        }
        let mut row = [0.0; NAMES.len()];
        form.read_row(element, values, &mut row)
            .and_then(|()| form.add(&row, soup, &mut clamped_count))
            .map_err(|error| error.at(format!("{file}, vertex {number}")))?;
    }
    let detail = "vertex colors beyond what their type allows; the nearest that are allowed were taken";
    context.warnings.add_many("clamped_color", &soup.file, detail, clamped_count);
    // Some programs write an alpha that nobody has set.
    let is_shown = |alpha: f32| alpha > 0.0;
    let alphas = || soup.colors.iter().map(|color| color.w);
    soup.has_alpha = form.has_alpha && alphas().any(is_shown) && alphas().any(|alpha| alpha < 1.0);
    Ok(())
}

impl Form {
    fn of(element: &Element, file: &str, context: &mut Context) -> Result<Self> {
        let properties = NAMES.map(|names| element.scalar(names));
        let has = |places: std::ops::Range<usize>| properties[places].iter().all(Option::is_some);
        if !has(0..3) {
            return Err(Error::invalid("the element `vertex` needs the properties x, y and z"));
        }
        let one = |place: usize| {
            properties[place].map_or(Some(1.0), |property| match element.properties[property].kind {
                Kind::U8 => Some(255.0),
                Kind::U16 => Some(65_535.0),
                Kind::F32 | Kind::F64 => Some(1.0),
                _ => None,
            })
        };
        let scale = [6, 7, 8, 9].map(one);
        let color_scale = match scale {
            [Some(r), Some(g), Some(b), Some(a)] if has(6..9) => Some([r, g, b, a]),
            _ => None,
        };
        if has(6..9) && color_scale.is_none() {
            let detail =
                "vertex colors of a type other than uchar, ushort, float and double; they were left out";
            context.warnings.add("unknown_color_type", file, detail);
        }
        let mut form = Self {
            places: vec![None; element.properties.len()],
            has_normals: has(3..6),
            color_scale,
            has_alpha: color_scale.is_some() && has(9..10),
            has_texcoords: has(10..12),
        };
        for (place, property) in properties.iter().enumerate() {
            if let Some(property) = *property {
                form.places[property] = Some(place);
            }
        }
        Ok(form)
    }

    fn read_row(&self, element: &Element, values: &mut Values, row: &mut Row) -> Result<()> {
        for (property, place) in element.properties.iter().zip(&self.places) {
            match (property.length, place) {
                (Some(length), _) => {
                    let count = values.length(length, property.kind)?;
                    values.skip(property.kind, count)?;
                }
                (None, Some(place)) => row[*place] = values.number(property.kind)?,
                (None, None) => values.skip(property.kind, 1)?,
            }
        }
        Ok(())
    }

    fn add(&self, row: &Row, soup: &mut Soup, clamped_count: &mut u64) -> Result<()> {
        let [x, y, z, nx, ny, nz, r, g, b, a, s, t] = *row;
        soup.positions.push(Vec3::from_array(finite([x, y, z], POSITION_MAX)?));
        if self.has_normals {
            soup.normals.push(Vec3::from_array(finite([nx, ny, nz], f32::MAX)?));
        }
        if self.has_texcoords {
            soup.texcoords.push(texcoord([s, t])?);
        }
        if let Some(scale) = self.color_scale {
            let a = if self.has_alpha { a } else { 1.0 };
            let stored = [r / scale[0], g / scale[1], b / scale[2], a / scale[3]];
            let stored = Vec4::from_array(finite(stored, f32::MAX)?);
            let color = stored.clamp(Vec4::ZERO, Vec4::ONE);
            *clamped_count += u64::from(color != stored);
            // Scanners and painting programs store what they show; glTF's COLOR_0 is linear.
            let [r, g, b, a] = color.to_array();
            soup.colors.push(Vec3::from_array([r, g, b].map(srgb_to_linear)).extend(a));
        }
        Ok(())
    }
}

/// With v upwards, as PLY has it, to glTF's convention.
pub fn texcoord(stored: [f64; 2]) -> Result<Vec2> {
    let [u, v] = finite(stored, UV_MAX)?;
    Ok(Vec2::new(u, (1.0 - v).clamp(-UV_MAX, UV_MAX)))
}

fn finite<const N: usize>(numbers: [f64; N], max: f32) -> Result<[f32; N]> {
    let single = numbers.map(|number| number as f32);
    match single.iter().find(|number| number.is_nan() || number.abs() > max) {
        None => Ok(single),
        Some(number) => Err(Error::invalid(format!("{number} is not a finite number within ±{max:e}"))),
    }
}
