//! Converted textures against the filters of mesh colors themselves: at places all over every face, at every level, what a
//! bilinear unit reads from the level image at the converted coordinates, and what [`crate::filter`] makes of the samples
//! that were stored. They are equal within the rounding of a texel, see [`BOUND`].

mod faces;

use glam::{Vec2, Vec4, Vec4Swizzles};

use self::faces::Faces;
use super::{Random, finish, noise_asset};
use crate::asset::{AlphaMode, Asset, Slot};
use crate::colors::{ChannelTopology, LevelNumbering};
use crate::filter::{Level, MeshColors, Triangles};
use crate::image::{Image, Pixels, Transfer};
use crate::math::transfer::linear_to_srgb;
use crate::pipeline::{Coordinates, Options, Range, Rounding};

/// Every texel is within half a code of what it should be. So is every mix of them where codes are linear, and of color as
/// long as `d linear / d code` is concave in the linear value: then the mean of the texels' errors is no more than half a
/// code at the mean of their values. On sRGB's straight start it is not: black mixed with code 31 can be off by 0.653.
const BOUND: f32 = 0.66;

/// How much more that is where texels are worked out from rounded samples: half a code of the samples, half a code of
/// points between two of them, and of border texels a quarter of their own half.
const BY_RULES: f32 = 2.25;

/// Of data with 16 bits, whose codes are 257 times finer; the most of it is what places in 32 bits are off on steep slopes.
const BOUND_16_BITS: f32 = 0.005;

/// What was seen at some places; differences in codes, the largest.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// Against the filter that reads triangles as a bilinear unit does.
    worst: f32,
    /// Against MC 4.1 where both are the same function: on quads, on the sides of a triangle's cells, in cells
    /// that a diagonal cuts, and beyond vertex colors.
    worst_same: f32,
    /// Against MC 4.1 in whole cells of triangles, where they are not.
    worst_whole: f32,
    place_count: usize,
    whole_count: usize,
    extrapolated_count: usize,
    /// In cells at a diagonal that nobody shares, whose border texel was clamped.
    clamped_count: usize,
    /// At levels that hold values out of [0, 1].
    ranged_count: usize,
}

impl Seen {
    fn join(self, other: Self) -> Self {
        Self {
            worst: self.worst.max(other.worst),
            worst_same: self.worst_same.max(other.worst_same),
            worst_whole: self.worst_whole.max(other.worst_whole),
            place_count: self.place_count + other.place_count,
            whole_count: self.whole_count + other.whole_count,
            extrapolated_count: self.extrapolated_count + other.extrapolated_count,
            clamped_count: self.clamped_count + other.clamped_count,
            ranged_count: self.ranged_count + other.ranged_count,
        }
    }
}

/// One channel of a converted material, and the colors that it was made from.
struct Sheet<'a> {
    faces: &'a Faces<'a>,
    channel: usize,
    levels: &'a [Level<'a>],
    /// As a bilinear unit reads triangles.
    ours: MeshColors<'a>,
    linear: MeshColors<'a>,
}

impl Sheet<'_> {
    /// Looks at one place.
    fn see(&self, (face, at): (usize, Vec2), level: usize) -> Seen {
        let numbering = self.levels[level].numbering;
        let is_extrapolated = self.faces.is_extrapolated(face, level);
        let is_ranged = self.faces.texture(face, self.channel).ranges.contains_key(&level);
        let mut seen = Seen {
            place_count: 1,
            extrapolated_count: usize::from(is_extrapolated),
            ranged_count: usize::from(is_ranged),
            ..Seen::default()
        };
        let (mut is_whole, mut more) = (false, Vec4::ZERO);
        if numbering.canvas.faces[face].is_triangle() && !is_extrapolated {
            let cell = self.cell((face, at), level);
            is_whole = !cell.is_cut && cell.part.min_element() > 0.0;
            // Nothing has to match on an edge that nobody shares: there the solver is not asked.
            if cell.is_cut && !is_ranged && self.faces.is_free(face, self.channel) {
                more = (cell.border.clamp(Vec4::ZERO, Vec4::ONE) - cell.border) * cell.part.x * cell.part.y;
                seen.clamped_count = usize::from(more != Vec4::ZERO);
            }
        }
        let found = self.faces.read(face, at, self.channel, level);
        let apart = |colors: &MeshColors<'_>| {
            self.codes_between(found, colors.linear(face, at, level) + more, (face, level))
        };
        seen.worst = apart(&self.ours);
        if is_whole {
            (seen.whole_count, seen.worst_whole) = (1, apart(&self.linear));
        } else {
            seen.worst_same = apart(&self.linear);
        }
        seen
    }

    /// The largest difference of the components that are stored.
    fn codes_between(&self, found: Vec4, wanted: Vec4, (face, level): (usize, usize)) -> f32 {
        let texture = self.faces.texture(face, self.channel);
        let codes = |value: Vec4| match texture.transfer {
            Transfer::Srgb => value.xyz().map(linear_to_srgb).extend(value.w) * 255.0,
            Transfer::Linear => value * 255.0,
        };
        let difference = (codes(found) - codes(wanted)).abs();
        let has_alpha = texture.levels[level].components.is_multiple_of(2);
        if has_alpha { difference.max_element() } else { difference.xyz().max_element() }
    }

    /// Where a place of a triangle falls among the cells that its texels make.
    fn cell(&self, (face, at): (usize, Vec2), level: usize) -> Cell {
        let Level { numbering, values } = self.levels[level];
        let right = usize::from(self.faces.right[face]);
        let n = numbering.shape(face).segments[0];
        let barycentrics = [1.0 - at.x - at.y, at.x, at.y];
        let place = [1, 2].map(|k| barycentrics[(right + k) % 3].max(0.0) * n as f32);
        let x = (place[0] as u32).min(n - 1);
        let y = (place[1] as u32).min(n - 1 - x);
        let value = |dx: u32, dy: u32| {
            let mut steps = [n - x - y - dx - dy; 3];
            (steps[(right + 1) % 3], steps[(right + 2) % 3]) = (x + dx, y + dy);
            numbering.tap(face, steps[1], steps[2]).value(values)
        };
        Cell {
            is_cut: x + y + 1 == n,
            part: Vec2::from(place) - Vec2::new(x as f32, y as f32),
            border: value(1, 0) + value(0, 1) - value(0, 0),
        }
    }
}

struct Cell {
    /// By the diagonal.
    is_cut: bool,
    part: Vec2,
    /// `c1 + c2 - c0` of a cut cell (MCT equation 1).
    border: Vec4,
}

/// Places of a face: its corners, its edges and all over it.
fn places(is_triangle: bool, random: &mut Random) -> Vec<Vec2> {
    let corners: &[Vec2] = if is_triangle {
        &[Vec2::ZERO, Vec2::X, Vec2::Y]
    } else {
        &[Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]
    };
    let mut places = corners.to_vec();
    for (k, corner) in corners.iter().enumerate() {
        let next = corners[(k + 1) % corners.len()];
        places.extend((0..6).map(|_| corner.lerp(next, random.next())));
    }
    places.extend((0..40).map(|_| {
        let at = Vec2::new(random.next(), random.next());
        if is_triangle && at.x + at.y > 1.0 { Vec2::ONE - at } else { at }
    }));
    places
}

/// What the faces of a conversion were seen to be; each is wanted among the cases.
#[derive(Clone, Copy, Debug, Default)]
struct Kinds {
    lone_count: usize,
    pair_count: usize,
    quad_count: usize,
    elongated_count: usize,
    /// Edges whose faces have unequal exponents along them.
    unequal_count: usize,
}

/// Looks at every level of the one channel of an asset.
fn compare(asset: &Asset, options: &Options) -> (Vec<Seen>, Kinds) {
    let (finished, conversions) = finish(asset, options);
    let conversion = &conversions[0];
    let faces = Faces::new(asset, &finished, conversion);
    let channel = &conversion.channels[0];
    let (canvas, resolutions) = (&conversion.canvas, &conversion.resolutions);
    let topology = ChannelTopology::new(canvas, resolutions, &channel.cuts);
    let numbering = |level| LevelNumbering::new(canvas, &topology, resolutions, level);
    let numberings: Vec<_> = (0..channel.samples.len()).map(numbering).collect();
    let level = |(numbering, values)| Level { numbering, values };
    let levels: Vec<_> =
        numberings.iter().zip(channel.samples.iter().map(Vec::as_slice)).map(level).collect();
    let sheet = Sheet {
        faces: &faces,
        channel: 0,
        levels: &levels,
        ours: MeshColors::new(&levels, Triangles::HalfSquares(&faces.right)).unwrap(),
        linear: MeshColors::new(&levels, Triangles::Linear).unwrap(),
    };
    let mut random = Random(11);
    let seen = (0..levels.len()).map(|level| {
        let all = canvas.faces.iter().enumerate().flat_map(|(face, of)| {
            places(of.is_triangle(), &mut random).into_iter().map(move |at| (face, at))
        });
        all.map(|place| sheet.see(place, level)).fold(Seen::default(), Seen::join)
    });
    let seen = seen.collect();
    let mut kinds = Kinds::default();
    for (face, [r, s]) in canvas.faces.iter().zip(&resolutions.faces) {
        let kind = match (face.is_triangle(), face.is_pair()) {
            (true, _) => &mut kinds.lone_count,
            (_, true) => &mut kinds.pair_count,
            _ => &mut kinds.quad_count,
        };
        *kind += 1;
        kinds.elongated_count += usize::from(r != s);
    }
    let is_unequal = |strip: &&crate::colors::Strip| {
        let along = |side: &crate::mesh::Side| resolutions.along(side.face as usize, side.edge.into());
        topology.sides(strip).iter().any(|side| along(side) != strip.exponent)
    };
    kinds.unequal_count = topology.strips.iter().filter(is_unequal).count();
    (seen, kinds)
}

/// Noise of one kind on a random sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Noise {
    Color,
    /// With alpha.
    Mask,
    Data16,
}

fn asset(noise: Noise) -> Asset {
    let slot = match noise {
        Noise::Color | Noise::Mask => Slot::BaseColor,
        Noise::Data16 => Slot::MetallicRoughness,
    };
    let mut asset = noise_asset(3, 6, slot);
    let mut random = Random(4);
    let mut codes =
        |count: usize| (0..64 * 64 * count).map(|_| (random.next() * 65535.0) as u16).collect::<Vec<_>>();
    match noise {
        Noise::Mask => {
            let pixels = Pixels::U8(codes(4).into_iter().map(|code| (code >> 8) as u8).collect());
            asset.images[0] = Image { width: 64, height: 64, components: 4, pixels };
            asset.materials[0].alpha_mode = AlphaMode::Mask(0.5);
        }
        Noise::Data16 => asset.images[0].pixels = Pixels::U16(codes(3)),
        Noise::Color => {}
    }
    asset
}

/// Asserts the bound at every level; returns what was seen of all.
fn hold(noise: Noise, options: &Options) -> (Seen, Kinds) {
    let bound = if noise == Noise::Data16 { BOUND_16_BITS } else { BOUND };
    let bound = if options.rounding == Rounding::Rules { bound * BY_RULES } else { bound };
    let (levels, kinds) = compare(&asset(noise), options);
    for (level, seen) in levels.iter().enumerate() {
        let worst = seen.worst.max(seen.worst_same);
        assert!(worst <= bound, "{noise:?}, {options:?}, level {level}: {seen:?}");
    }
    (levels.into_iter().fold(Seen::default(), Seen::join), kinds)
}

/// With every edge joined, so that faces of unequal exponents meet, and with cuts.
#[test]
fn textures_are_what_filters_make_of_their_samples() {
    for coordinates in [Coordinates::Indexed, Coordinates::Scaled] {
        for (noise, rounding, cut_codes) in [
            (Noise::Color, Rounding::Nearest, 255.0),
            (Noise::Color, Rounding::Rules, 255.0),
            (Noise::Mask, Rounding::Nearest, 8.0),
            (Noise::Data16, Rounding::Nearest, 255.0),
        ] {
            let options =
                Options { coordinates, rounding, cut_codes, range: Range::Unorm8, ..Options::default() };
            let (seen, kinds) = hold(noise, &options);
            let Kinds { lone_count, pair_count, quad_count, elongated_count, unequal_count } = kinds;
            assert!(lone_count.min(quad_count).min(elongated_count) > 0, "{kinds:?}");
            assert_eq!(cut_codes == 255.0, pair_count.min(unequal_count) > 0, "{kinds:?}");
            assert_eq!(coordinates == Coordinates::Scaled, seen.extrapolated_count > 0);
            assert!(seen.clamped_count > 0 && seen.whole_count > 100);
            assert!(seen.worst_whole > 8.0, "half squares and three samples differ: {seen:?}");
        }
    }
}

/// Levels that hold texels out of [0, 1], 16 bits or half floats of them.
#[test]
fn ranges_hold_what_filters_make_of_their_samples() {
    for (range, rounding) in [(Range::Scaled16, Rounding::Nearest), (Range::Float16, Rounding::Rules)] {
        let coordinates = Coordinates::Scaled;
        let options = Options { coordinates, rounding, range, cut_codes: 255.0, ..Options::default() };
        let (seen, _) = hold(Noise::Color, &options);
        assert!(seen.extrapolated_count > 0 && seen.ranged_count > 0, "{seen:?}");
    }
}
