//! A stored image as a sampler sees it: decoded, wrapped, filtered. Written here once more, apart from
//! the code that made the images, so that a mistake there cannot hide itself.
//!
//! Codes are decoded by table at every fetch: a level of 13 M texels costs no memory beyond its own.

use std::sync::LazyLock;

use glam::{Vec2, Vec3, Vec4};
use half::f16;

use crate::image::{Image, LevelRange, Pixels, Transfer, Wrap, WrapMode};

/// Wrap of a converted level: its sampler clamps.
pub const CLAMPED: Wrap = Wrap { s: WrapMode::ClampToEdge, t: WrapMode::ClampToEdge };

/// Decoding tables of one depth.
pub struct Tables {
    /// For color.
    pub srgb: Vec<f32>,
    /// For data and alpha.
    pub plain: Vec<f32>,
}

fn tables(last_code: u32) -> Tables {
    let share = |code: u32| f64::from(code) / f64::from(last_code);
    // IEC 61966-2-1.
    let light = |v: f64| if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    Tables {
        srgb: (0..=last_code).map(|code| light(share(code)) as f32).collect(),
        plain: (0..=last_code).map(|code| share(code) as f32).collect(),
    }
}

static OF_8_BITS: LazyLock<Tables> = LazyLock::new(|| tables(255));
static OF_16_BITS: LazyLock<Tables> = LazyLock::new(|| tables(65535));

/// What 16 bits are as half floats.
static OF_HALF_FLOATS: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..=u16::MAX).map(|bits| f16::from_bits(bits).to_f32()).collect());

/// The tables of an image's depth; values need none.
pub fn tables_of(image: &Image) -> &'static Tables {
    match image.pixels {
        Pixels::U8(_) => &OF_8_BITS,
        Pixels::U16(_) | Pixels::F32(_) => &OF_16_BITS,
    }
}

/// The tables of 8-bit codes.
pub fn of_8_bits() -> &'static Tables {
    &OF_8_BITS
}

/// Steps of the encoding table: its error stays under 0.0004 codes, far below a rounding.
const ENCODE_STEPS: usize = 16384;

static ENCODE: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let code = |v: f64| 255.0 * if v <= 0.0031308 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (0..=ENCODE_STEPS + 1).map(|step| code((step as f64 / ENCODE_STEPS as f64).min(1.0)) as f32).collect()
});

/// Linear light to 8-bit sRGB codes, not rounded; clamped to [0, 255].
pub fn encode_codes(linear: f32) -> f32 {
    let at = linear.clamp(0.0, 1.0) * ENCODE_STEPS as f32;
    let step = at as usize;
    let table = &*ENCODE;
    let (low, high) = (table[step], table[step + 1]);
    low + (high - low) * (at - step as f32)
}

/// An image with the meaning of its codes and its wrap modes.
#[derive(Clone, Copy)]
pub struct Texels<'a> {
    image: &'a Image,
    wrap: Wrap,
    tables: Decoding,
    /// Scale and bias of what the tables give.
    scaled: Option<[Vec4; 2]>,
}

/// For color, and for data and alpha; by depth.
#[derive(Clone, Copy)]
enum Decoding {
    Eight([&'static [f32; 256]; 2]),
    Sixteen([&'static [f32]; 2]),
}

impl<'a> Texels<'a> {
    pub fn new(image: &'a Image, transfer: Transfer, wrap: Wrap) -> Self {
        let tables = tables_of(image);
        let of_color = if transfer == Transfer::Srgb { &tables.srgb } else { &tables.plain };
        let tables = match [of_color, &tables.plain].map(|table| <&[f32; 256]>::try_from(table.as_slice())) {
            [Ok(color), Ok(plain)] => Decoding::Eight([color, plain]),
            _ => Decoding::Sixteen([of_color, &tables.plain]),
        };
        Self { image, wrap, tables, scaled: None }
    }

    /// The same with codes that mean what a level's range says, whatever the transfer.
    pub fn in_range(self, range: Option<&LevelRange>) -> Self {
        let tables = match (range, self.tables) {
            (Some(LevelRange::Float16), Decoding::Sixteen(_)) => Decoding::Sixteen([&OF_HALF_FLOATS; 2]),
            (Some(LevelRange::Scaled16 { .. }), Decoding::Sixteen([_, plain])) => {
                Decoding::Sixteen([plain; 2])
            }
            (_, tables) => tables,
        };
        let scaled = match range {
            Some(LevelRange::Scaled16 { scale, bias }) => Some([*scale, *bias]),
            _ => None,
        };
        Self { tables, scaled, ..self }
    }

    pub fn size_texels(&self) -> Vec2 {
        Vec2::new(self.image.width as f32, self.image.height as f32)
    }

    /// The bilinear value at a place in texels (centers at `.5`): red, green, blue, alpha; gray stands
    /// in all three, and alpha is 1 where there is none.
    #[inline]
    pub fn bilinear(&self, at_texels: Vec2) -> [f32; 4] {
        self.filtered(at_texels).to_array()
    }

    #[inline]
    pub fn filtered(&self, at_texels: Vec2) -> Vec4 {
        let (cell, part) = cell_of(at_texels);
        mixed(&self.corners(cell), part)
    }

    /// The decoded texels around a cell: those that stand at its number, one to the right, one below,
    /// and both. Whoever follows a line fetches them once for each cell.
    #[inline]
    pub fn corners(&self, [x, y]: [i32; 2]) -> [Vec4; 4] {
        let [width, height] = self.image.size();
        let columns = neighbors(x, self.wrap.s, width);
        let rows = neighbors(y, self.wrap.t, height).map(|row| row * width as usize);
        let at = [rows[0] + columns[0], rows[0] + columns[1], rows[1] + columns[0], rows[1] + columns[1]];
        let four = match (&self.image.pixels, self.tables) {
            (Pixels::U8(codes), Decoding::Eight([color, plain])) => {
                let [color, plain] = [color, plain].map(|table| move |code: u8| table[usize::from(code)]);
                decoded(codes, self.image.components, at, color, plain)
            }
            (Pixels::U16(codes), Decoding::Sixteen([color, plain])) => {
                let [color, plain] = [color, plain].map(|table| move |code: u16| table[usize::from(code)]);
                decoded(codes, self.image.components, at, color, plain)
            }
            (Pixels::F32(of), _) => decoded(&of.values, self.image.components, at, |v| v, |v| v),
            // Tables are of the image's depth.
            _ => [Vec4::ZERO; 4],
        };
        match self.scaled {
            None => four,
            Some([scale, bias]) => {
                let [a, b, c, d] = four;
                let of = |value: Vec4| value * scale + bias;
                [of(a), of(b), of(c), of(d)]
            }
        }
    }

    /// Whether two straight runs of `count` texels, the first here and the second in `other`, hold the same codes, and
    /// the codes mean the same. False where a run leaves its image.
    pub fn equal_runs(&self, other: &Texels<'_>, runs: [Run; 2], count: i32) -> bool {
        if !self.decodes_as(other) {
            return false;
        }
        match (&self.image.pixels, &other.image.pixels) {
            (Pixels::U8(here), Pixels::U8(there)) => {
                equal_codes([(self.image, here), (other.image, there)], runs, count)
            }
            (Pixels::U16(here), Pixels::U16(there)) => {
                equal_codes([(self.image, here), (other.image, there)], runs, count)
            }
            _ => false,
        }
    }

    fn decodes_as(&self, other: &Texels<'_>) -> bool {
        let is_one = match (self.tables, other.tables) {
            (Decoding::Eight(here), Decoding::Eight(there)) => {
                here.iter().zip(there).all(|(here, there)| std::ptr::eq(*here, there))
            }
            (Decoding::Sixteen(here), Decoding::Sixteen(there)) => {
                here.iter().zip(there).all(|(here, there)| std::ptr::eq(*here, there))
            }
            _ => false,
        };
        is_one && self.scaled == other.scaled && self.image.components == other.image.components
    }
}

/// A straight run of texels: the first, and the step to the next.
pub type Run = ([i32; 2], [i32; 2]);

fn equal_codes<T: Copy + PartialEq>(images: [(&Image, &Vec<T>); 2], runs: [Run; 2], count: i32) -> bool {
    let texel = |which: usize, step: i32| {
        let (image, codes) = images[which];
        let ([x, y], [right, down]) = runs[which];
        let size = image.size().map(i64::from);
        let components = usize::from(image.components);
        let at = |from: i32, by: i32| i64::from(from) + i64::from(by) * i64::from(step);
        let (x, y) = (at(x, right), at(y, down));
        let is_inside = (0..size[0]).contains(&x) && (0..size[1]).contains(&y);
        is_inside.then(|| &codes[(y * size[0] + x) as usize * components..][..components])
    };
    (0..count).all(|step| matches!((texel(0, step), texel(1, step)), (Some(a), Some(b)) if a == b))
}

/// Texels as red, green, blue, alpha.
#[inline(always)]
fn decoded<T: Copy>(
    codes: &[T],
    components: u8,
    [a, b, c, d]: [usize; 4],
    color: impl Fn(T) -> f32,
    plain: impl Fn(T) -> f32,
) -> [Vec4; 4] {
    match components {
        1 => {
            let of = |texel: usize| Vec3::splat(color(codes[texel])).extend(1.0);
            [of(a), of(b), of(c), of(d)]
        }
        2 => {
            let texels = codes.as_chunks::<2>().0;
            let of = |texel: usize| Vec3::splat(color(texels[texel][0])).extend(plain(texels[texel][1]));
            [of(a), of(b), of(c), of(d)]
        }
        3 => {
            let texels = codes.as_chunks::<3>().0;
            let of = |texel: usize| {
                let [red, green, blue] = texels[texel];
                Vec4::new(color(red), color(green), color(blue), 1.0)
            };
            [of(a), of(b), of(c), of(d)]
        }
        _ => {
            let texels = codes.as_chunks::<4>().0;
            let of = |texel: usize| {
                let [red, green, blue, alpha] = texels[texel];
                Vec4::new(color(red), color(green), color(blue), plain(alpha))
            };
            [of(a), of(b), of(c), of(d)]
        }
    }
}

/// The cell between texel centers that a place lies in, and where in it, 0 to 1.
#[inline]
pub fn cell_of(at_texels: Vec2) -> ([i32; 2], Vec2) {
    let ((x, part_x), (y, part_y)) = (cell_along(at_texels.x), cell_along(at_texels.y));
    ([x, y], Vec2::new(part_x, part_y))
}

#[inline]
fn cell_along(place_texels: f32) -> (i32, f32) {
    // Places that still have a texel number.
    const FAR_TEXELS: f32 = 1e9;
    #[expect(clippy::manual_clamp, reason = "clamp keeps NaN; in this order it becomes a number")]
    let from_center = place_texels.max(-FAR_TEXELS).min(FAR_TEXELS) - 0.5;
    // The floor, without a call where the processor's own is not to be counted on.
    let toward_zero = from_center as i32;
    let first = if toward_zero as f32 > from_center { toward_zero - 1 } else { toward_zero };
    (first, from_center - first as f32)
}

/// The bilinear value inside a cell.
#[inline]
pub fn mixed([a, b, c, d]: &[Vec4; 4], part: Vec2) -> Vec4 {
    let top = *a + (*b - *a) * part.x;
    let bottom = *c + (*d - *c) * part.x;
    top + (bottom - top) * part.y
}

/// A texel along one axis and the next one, wrapped.
#[inline]
fn neighbors(first: i32, mode: WrapMode, size: u32) -> [usize; 2] {
    // Most fetches fall inside, and the remainder of wide integers is slow.
    if first >= 0 && i64::from(first) + 1 < i64::from(size) {
        return [first as usize, first as usize + 1];
    }
    [i64::from(first), i64::from(first) + 1].map(|at| mode.apply(at, size) as usize)
}

/// The components that an image of this many stores, of red, green, blue, alpha.
pub fn stored_components(count: u8) -> &'static [usize] {
    match count {
        1 => &[0],
        2 => &[0, 3],
        3 => &[0, 1, 2],
        _ => &[0, 1, 2, 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::transfer::linear_to_srgb;

    #[test]
    fn the_encoding_table_is_the_function() {
        for step in 0..=100_000 {
            let linear = step as f32 / 100_000.0;
            assert!((encode_codes(linear) - 255.0 * linear_to_srgb(linear)).abs() < 1e-3, "{linear}");
        }
        assert_eq!((encode_codes(-1.0), encode_codes(f32::NAN) >= 0.0), (0.0, false));
        assert!((encode_codes(7.0) - 255.0).abs() < 1e-3);
    }

    #[test]
    fn filters_in_linear_light_and_wraps() {
        let image = Image { width: 2, height: 1, components: 1, pixels: Pixels::U8(vec![0, 255]) };
        let clamped = Texels::new(&image, Transfer::Srgb, CLAMPED);
        assert_eq!(clamped.bilinear(Vec2::new(1.0, 0.5)), [0.5, 0.5, 0.5, 1.0]);
        assert_eq!(clamped.bilinear(Vec2::new(-3.0, 9.0))[0], 0.0);
        for far in [f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
            assert!(clamped.bilinear(Vec2::new(far, far))[0].is_finite());
        }
        let repeated = Texels::new(&image, Transfer::Srgb, Wrap::default());
        assert_eq!(repeated.bilinear(Vec2::new(-0.25, 0.5))[0], 0.75);
        assert!((encode_codes(0.5) - 187.516).abs() < 1e-2);
    }

    #[test]
    fn ranges_take_the_place_of_the_transfer() {
        let bits = [-2.0, 6.0].map(|value| f16::from_f32(value).to_bits());
        let image = Image { width: 2, height: 1, components: 1, pixels: Pixels::U16(bits.to_vec()) };
        let of = |image, range| Texels::new(image, Transfer::Srgb, CLAMPED).in_range(Some(&range));
        assert_eq!(of(&image, LevelRange::Float16).bilinear(Vec2::new(0.75, 0.5)), [0.0, 0.0, 0.0, 1.0]);
        let image = Image { pixels: Pixels::U16(vec![0, 65535]), ..image };
        let range = LevelRange::Scaled16 {
            scale: Vec4::new(8.0, 8.0, 8.0, 1.0),
            bias: Vec4::new(-2.0, -2.0, -2.0, 0.0),
        };
        assert_eq!(of(&image, range).bilinear(Vec2::new(0.75, 0.5)), [0.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn sixteen_bits_and_alpha_are_plain() {
        let pixels = Pixels::U16(vec![0, 65535, 65535, 0]);
        let image = Image { width: 2, height: 1, components: 2, pixels };
        let texels = Texels::new(&image, Transfer::Srgb, CLAMPED);
        assert_eq!(texels.bilinear(Vec2::new(0.75, 0.5)), [0.25, 0.25, 0.25, 0.75]);
    }
}
