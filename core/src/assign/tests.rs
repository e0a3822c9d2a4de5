use glam::{DVec2, Vec2, Vec3, Vec4};

use super::paint::corner_weights;
use super::{
    Codec, LevelChannel, LevelValues, Need, NormalFrames, Range, Rounding, Storing, choose_frames,
    need_of_range, paint, range_of, read_back, rules,
};
use crate::colors::{ChannelTopology, Cuts, LevelNumbering, Resolutions};
use crate::image::{Image, LevelRange, Pixels, Transfer, Wrap, WrapMode, bilinear};
use crate::layout::{Coordinates, Layout, LayoutRequest, arrange};
use crate::mesh::{CanvasMesh, Polygons, build};
use crate::watch::Unwatched;

const DATA16: Codec = Codec { transfer: Transfer::Linear, components: 3, bits: 16 };
const PLAIN: Storing = Storing { rounding: Rounding::Rules, range: None };
const CLAMP: Wrap = Wrap { s: WrapMode::ClampToEdge, t: WrapMode::ClampToEdge };

struct Case {
    canvas: CanvasMesh,
    resolutions: Resolutions,
    layout: Layout,
}

/// A lone triangle beside a quad, the triangle's diagonal on the edge that they share.
fn triangle_and_quad(exponents: [u8; 2], levels: usize) -> Case {
    case_of(Resolutions::uniform(exponents), levels, Coordinates::Scaled)
}

fn case_of(resolutions: Resolutions, levels: usize, coordinates: Coordinates) -> Case {
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(2.0, 1.0, 0.0), Vec3::new(1.0, 2.0, 0.0)];
    let mut faces = [([0, 1, 2, 0], 3), ([1, 3, 4, 2], 4)].into_iter();
    let canvas = build([Polygons { mesh: 0, primitive: 0, positions: &positions, faces: &mut faces }]);
    let layouts = arrange(&[LayoutRequest {
        canvas: &canvas,
        resolutions: &resolutions,
        diagonals: &[1, 0],
        level_count: levels,
        side_limit: 16_384,
        part_side: 16_384,
        coordinates,
    }]);
    Case { layout: layouts.unwrap().remove(0), canvas, resolutions }
}

/// One channel at one level, all edges joined; with the number of its vertex samples.
fn on_level<T>(
    case: &Case,
    level: usize,
    (codec, frames): (Codec, Option<&NormalFrames>),
    then: impl FnOnce(&LevelChannel<'_>, usize) -> T,
) -> T {
    let cuts = Cuts::none(&case.canvas);
    let topology = ChannelTopology::new(&case.canvas, &case.resolutions, &cuts);
    let numbering = LevelNumbering::new(&case.canvas, &topology, &case.resolutions, level);
    let channel = LevelChannel { layout: &case.layout, numbering: &numbering, cuts: &cuts, codec, frames };
    then(&channel, topology.fan_count())
}

fn painted(case: &Case, level: usize, value: impl Fn(usize) -> f32) -> (Image, Vec<Vec4>, usize) {
    on_level(case, level, (DATA16, None), |channel, fan_count| {
        let samples: Vec<Vec4> =
            (0..channel.numbering.sample_count()).map(|k| Vec4::splat(value(k))).collect();
        let values = LevelValues::new(samples.clone(), fan_count);
        (paint(channel, &values, PLAIN, &Unwatched).unwrap(), samples, rules(channel).len())
    })
}

const COLOR8: Codec = Codec { transfer: Transfer::Srgb, components: 3, bits: 8 };

/// Far apart colors beyond vertex colors: the range that the level asks for, and its image.
fn in_range(
    case: &Case,
    level: usize,
    range: Range,
    value: impl Fn(usize) -> f32,
) -> Option<(LevelRange, Image)> {
    on_level(case, level, (COLOR8, None), |channel, fan_count| {
        let samples = (0..channel.numbering.sample_count()).map(|k| Vec4::splat(value(k))).collect();
        let values = LevelValues::new(samples, fan_count);
        if need_of_range(channel, &values, range, &Unwatched).unwrap() == Need::Plain {
            return None;
        }
        let range = range_of(channel, &values, (range, false), &Unwatched).unwrap();
        let storing = Storing { rounding: Rounding::Rules, range: Some(range) };
        let image = paint(channel, &values, storing, &Unwatched).unwrap();
        let changes = read_back(channel, &values, &image, &range);
        assert_eq!(changes.len(), channel.numbering.sample_count());
        assert!(changes.iter().all(|change| *change < 0.7), "{changes:?}");
        Some((range, image))
    })
}

/// What two far colors ask for grows with the level; what is wider than any range says so.
#[test]
fn what_no_range_is_wide_enough_for_is_told() {
    let case = triangle_and_quad([0, 0], 5);
    let need = |level: usize, apart: f32| {
        on_level(&case, level, (COLOR8, None), |channel, fan_count| {
            let samples = (0..channel.numbering.sample_count()).map(|k| Vec4::splat(apart * (k % 2) as f32));
            let values = LevelValues::new(samples.collect(), fan_count);
            need_of_range(channel, &values, Range::Float16, &Unwatched).unwrap()
        })
    };
    assert_eq!(need(1, 1.0), Need::Ranged { is_too_wide: false });
    assert_eq!(need(4, 1.0), Need::Ranged { is_too_wide: true });
    assert_eq!(need(4, 0.1), Need::Ranged { is_too_wide: false });
    assert_eq!(need(4, 0.0), Need::Plain);
}

/// Texels out of [0, 1] are stored, and read back to the corner colors on both sides.
#[test]
fn a_range_holds_what_the_bounded_format_cannot() {
    let case = triangle_and_quad([0, 0], 4);
    let noise = |k: usize| if k.is_multiple_of(2) { 0.9 } else { 0.1 };
    for (range, worst) in [(Range::Scaled16, 2e-4), (Range::Float16, 2e-3)] {
        assert!(in_range(&case, 0, range, noise).is_none(), "level 0 is never beyond vertex colors");
        assert!(in_range(&case, 2, range, |_| 0.5).is_none(), "flat colors stay in [0, 1]");
        for level in 1..4 {
            let Some((range, image)) = in_range(&case, level, range, noise) else { panic!("level {level}") };
            assert!(matches!(image.pixels, Pixels::U16(_)));
            for (of_triangle, of_quad) in [(1, 0), (2, 3)] {
                let read = [(0, of_triangle), (1, of_quad)].map(|(face, corner)| {
                    let place = case.layout.place(face, corner, level);
                    let (first, part) = ((place - 0.5).floor(), (place - 0.5).fract());
                    let texel =
                        |dx: u32, dy: u32| range.texel(&image, first.x as u32 + dx, first.y as u32 + dy).x;
                    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
                    mix(mix(texel(0, 0), texel(1, 0), part.x), mix(texel(0, 1), texel(1, 1), part.x), part.y)
                });
                assert!((read[0] - read[1]).abs() < worst, "{range:?}, level {level}: {read:?}");
                assert!((read[0] - 0.9).abs().min((read[0] - 0.1).abs()) < worst, "level {level}: {read:?}");
            }
        }
        assert!(in_range(&case, 2, Range::Unorm8, noise).is_none());
    }
}

/// The two roundings differ where a texel is made of samples: in linear formats the rules hold to the code.
#[test]
fn borders_of_linear_formats_keep_their_rule_to_the_code() {
    let case = triangle_and_quad([3, 1], 2);
    let cuts = Cuts::none(&case.canvas);
    let topology = ChannelTopology::new(&case.canvas, &case.resolutions, &cuts);
    let numbering = LevelNumbering::new(&case.canvas, &topology, &case.resolutions, 0);
    let codec = Codec { transfer: Transfer::Linear, components: 1, bits: 8 };
    let channel =
        LevelChannel { layout: &case.layout, numbering: &numbering, cuts: &cuts, codec, frames: None };
    let value = |k: usize| Vec4::splat(0.4 + 0.2 * ((k * 7919 % 131) as f32 / 131.0));
    let samples = (0..numbering.sample_count()).map(value).collect();
    let values = LevelValues::new(samples, topology.fan_count());
    let broken = |rounding: Rounding| {
        let storing = Storing { rounding, range: None };
        let image = paint(&channel, &values, storing, &Unwatched).unwrap();
        let Pixels::U8(codes) = &image.pixels else { panic!("8 bits") };
        let code = |at: Vec2| i32::from(codes[at.y as usize * image.width as usize + at.x as usize]);
        let corner = |k: usize| case.layout.place(0, k, 0).floor();
        let [low, high] = [corner(1), corner(2)];
        let inward = (corner(0) - (low + high) / 2.0).signum();
        let cells = (0..8).map(|step| low + (high - low) * (step as f32 / 8.0));
        let along = (high - low) / 8.0;
        cells
            .filter(|&c1| {
                // The cell between two texels of the diagonal: one corner inside, the border texel outside.
                let c2 = c1 + along;
                let c0 = Vec2::new(
                    if inward.x > 0.0 { c1.x.max(c2.x) } else { c1.x.min(c2.x) },
                    if inward.y > 0.0 { c1.y.max(c2.y) } else { c1.y.min(c2.y) },
                );
                code(c1) + code(c2) != code(c0) + code(c1 + c2 - c0)
            })
            .count()
    };
    assert_eq!(broken(Rounding::Rules), 0);
    assert!(broken(Rounding::Nearest) > 0);
}

fn at(case: &Case, image: &Image, level: usize, face: usize, weights: &[(usize, f32)]) -> f32 {
    let place = weights.iter().map(|&(corner, weight)| case.layout.place(face, corner, level) * weight).sum();
    bilinear(image, Transfer::Linear, CLAMP, place).x
}

/// MCT equation 1: along the diagonal the bilinear value depends on the two edge samples alone, so the quad,
/// which has the edge on a side, reads the same.
#[test]
fn a_diagonal_reads_like_the_side_of_its_neighbor() {
    let uniform = [[3, 3], [3, 1], [2, 4]].map(|exponents| {
        let last = usize::from(exponents[0].max(exponents[1]));
        (Resolutions::uniform(exponents), Coordinates::Scaled, last)
    });
    // Of elongated quads, with coordinates that reach to any level.
    let elongated = [[3, 3], [3, 1], [1, 3], [2, 4], [4, 0], [0, 4]]
        .map(|quad| (Resolutions { faces: vec![[3, 3], quad] }, Coordinates::Indexed, 5));
    for (resolutions, coordinates, last) in uniform.into_iter().chain(elongated) {
        let exponents = resolutions.faces.clone();
        let case = case_of(resolutions, 6, coordinates);
        for level in 0..=last {
            let noise = |k: usize| 0.35 + 0.1 * ((k * 7919 % 31) as f32 / 31.0);
            let (image, _, _) = painted(&case, level, noise);
            for step in 0..=64 {
                let t = step as f32 / 64.0;
                let triangle = at(&case, &image, level, 0, &[(1, 1.0 - t), (2, t)]);
                let quad = at(&case, &image, level, 1, &[(0, 1.0 - t), (3, t)]);
                assert!(
                    (triangle - quad).abs() < 1e-3,
                    "{exponents:?}, level {level}, t {t}: {triangle} {quad}"
                );
            }
        }
    }
}

/// Beyond vertex colors along the short side alone, and along both, an elongated quad shows its samples on every
/// column, and along its edge what the triangle there shows.
#[test]
fn elongated_quads_reach_beyond_vertex_colors_in_one_direction_first() {
    for quad in [[4, 0], [0, 4], [3, 1], [1, 3], [2, 4], [4, 2]] {
        let case = case_of(Resolutions { faces: vec![[3, 3], quad] }, 7, Coordinates::Scaled);
        let mut columns_seen = 0;
        for level in 0..7 {
            // Small slopes keep every texel in range.
            let noise = |k: usize| 0.5 + 0.002 * ((k * 7919 % 31) as f32 / 31.0);
            let (image, samples, row_count) = painted(&case, level, noise);
            let block = case.layout.block(1);
            if case.layout.is_beyond_across(block, level) {
                let column_count = (1 << (usize::from(quad[0].max(quad[1])) - level)) + 1;
                let of_triangle = if level <= 3 { 1 << (3 - level) } else { 4 };
                assert_eq!(row_count, 2 * column_count + of_triangle);
                columns_seen += 1;
            }
            let shown = |weights: &[(usize, f32)]| at(&case, &image, level, 1, weights);
            on_level(&case, level, (DATA16, None), |channel, _| {
                let shape = channel.numbering.shape(1);
                for (i, j) in
                    (0..=shape.segments[1]).flat_map(|j| (0..=shape.segments[0]).map(move |i| (i, j)))
                {
                    let [s, t] = shape.unit(i, j);
                    let wanted = channel.numbering.tap(1, i, j).value(&samples).x;
                    let read = shown(&[
                        (0, (1.0 - s) * (1.0 - t)),
                        (1, s * (1.0 - t)),
                        (2, s * t),
                        (3, (1.0 - s) * t),
                    ]);
                    assert!(
                        (read - wanted).abs() < 5e-5,
                        "{quad:?}, level {level}, {i} {j}: {read}, not {wanted}"
                    );
                }
            });
            for step in 0..=64 {
                let t = step as f32 / 64.0;
                let triangle = at(&case, &image, level, 0, &[(1, 1.0 - t), (2, t)]);
                let quad_shows = shown(&[(0, 1.0 - t), (3, t)]);
                assert!((triangle - quad_shows).abs() < 5e-5, "{quad:?}, level {level}, t {t}");
            }
        }
        assert_eq!(columns_seen, usize::from(quad[0].abs_diff(quad[1])));
    }
}

/// Beyond vertex colors the texels around a face reproduce its corner colors.
#[test]
fn corners_are_read_back_beyond_vertex_colors() {
    let case = triangle_and_quad([0, 0], 4);
    for level in 1..4 {
        // Small slopes keep every texel in range.
        let (image, values, row_count) = painted(&case, level, |k| 0.5 + 0.004 * k as f32);
        assert_eq!(row_count, 8, "four texels of each face");
        let cuts = Cuts::none(&case.canvas);
        let topology = ChannelTopology::new(&case.canvas, &case.resolutions, &cuts);
        for face in 0..2 {
            for corner in 0..case.canvas.faces[face].count() {
                let expected = values[topology.fan_of[face][corner] as usize].x;
                let read = at(&case, &image, level, face, &[(corner, 1.0)]);
                assert!((read - expected).abs() < 2e-5, "level {level}: {read}, not {expected}");
            }
        }
    }
}

#[test]
fn extrapolation_weights_reproduce_their_functions() {
    let all = [[true; 2]; 2];
    for missing in [None, Some([0, 0]), Some([1, 0]), Some([0, 1]), Some([1, 1])] {
        let mut there = all;
        if let Some([x, y]) = missing {
            there[y][x] = false;
        }
        let at = DVec2::new(-3.25, 2.5);
        let weights = corner_weights(there, at);
        let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
        let linear: f64 = weights.iter().map(|([x, y], weight)| weight * (2.0 * *x as f64 - *y as f64)).sum();
        assert!((sum - 1.0).abs() < 1e-5);
        assert!((linear - (2.0 * at.x - at.y)).abs() < 1e-4, "{missing:?}: {linear}");
    }
}

/// A normal stored in a face's frame comes back as itself through the frame that a viewer blends.
#[test]
fn stored_normals_decode_to_what_they_were() {
    let case = triangle_and_quad([1, 1], 2);
    let normals = vec![[Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 0.6, 0.8), Vec3::Z]; 2];
    for scale in [1.0, 0.5, 2.0] {
        let frames: NormalFrames =
            choose_frames(&case.canvas, &normals, &vec![None; case.canvas.faces.len()], scale);
        let wanted = Vec3::new(0.3, -0.2, 0.9).normalize();
        let (s, t) = (0.25, 0.5);
        let stored = Vec3::splat(0.5) + frames.to_stored(&case.canvas, 0, s, t) * wanted;
        assert!(stored.min_element() >= 0.0 && stored.max_element() <= 1.0);
        let corners = &frames.corners[0];
        let frame =
            crate::math::frame::Frame::blend([0, 1, 2].map(|k| &corners[k]), Vec3::new(1.0 - s - t, s, t));
        let decoded = frame * ((stored * 2.0 - 1.0) * Vec3::new(scale, scale, 1.0));
        assert!(decoded.normalize().angle_between(wanted) < 1e-3, "scale {scale}");
    }
}

/// Twelve levels beyond vertex colors the weights are in the millions; a flat color stays what it is.
#[test]
fn a_flat_color_stays_flat_at_any_distance() {
    let case = triangle_and_quad([0, 12], 13);
    for level in 0..13 {
        let (image, _, _) = painted(&case, level, |_| 0.7);
        for weights in [[(0, 0.3), (1, 0.3), (2, 0.4)], [(0, 1.0), (1, 0.0), (2, 0.0)]] {
            let read = at(&case, &image, level, 0, &weights);
            assert!((read - 0.7).abs() < 2e-5, "level {level}: {read}");
        }
    }
    let quads = triangle_and_quad([12, 0], 13);
    for level in 0..13 {
        let (image, _, _) = painted(&quads, level, |_| 0.7);
        let read = at(&quads, &image, level, 1, &[(0, 0.25), (1, 0.25), (2, 0.25), (3, 0.25)]);
        assert!((read - 0.7).abs() < 2e-5, "level {level}: {read}");
    }
}

/// Normals are read back as faces store them: those along the axes of a model too.
#[test]
fn normals_in_a_range_are_changed_by_its_rounding_alone() {
    let case = triangle_and_quad([0, 2], 3);
    let across = vec![[Vec3::X; 4]; 2];
    let frames = choose_frames(&case.canvas, &across, &vec![None; case.canvas.faces.len()], 1.0);
    let lean =
        |k: usize| Vec3::new(1.0, 0.02 * (k % 5) as f32, -0.03 * (k % 3) as f32).normalize().extend(1.0);
    let codec = Codec { transfer: Transfer::Linear, components: 3, bits: 8 };
    on_level(&case, 1, (codec, Some(&frames)), |channel, fan_count| {
        let samples: Vec<Vec4> = (0..channel.numbering.sample_count()).map(lean).collect();
        let values = LevelValues::new(samples, fan_count);
        let range = range_of(channel, &values, (Range::Scaled16, false), &Unwatched).unwrap();
        let storing = Storing { rounding: Rounding::Rules, range: Some(range) };
        let image = paint(channel, &values, storing, &Unwatched).unwrap();
        let changes = read_back(channel, &values, &image, &range);
        assert!(changes.iter().all(|change| *change < 0.1), "{changes:?}");
        assert!(changes.iter().filter(|change| **change > 0.0).count() > changes.len() / 2, "{changes:?}");
    });
}

/// Lines of normals, interpolated along the line, give what one point at a time gives.
#[test]
fn lines_of_normals_are_stored_as_single_ones() {
    let case = triangle_and_quad([3, 3], 2);
    let lean = |x: f32, y: f32| Vec3::new(x, y, 1.0).normalize();
    let normals = vec![[lean(0.1, 0.0), lean(0.9, -0.4), lean(0.0, 0.7), lean(-0.6, -0.6)]; 2];
    for scale in [1.0, 0.5, -2.0] {
        let frames = choose_frames(&case.canvas, &normals, &vec![None; case.canvas.faces.len()], scale);
        for (face, at, step) in [
            (0, [0.0, 0.25], [0.125, 0.0]),
            (0, [1.0, 0.0], [-0.125, 0.125]),
            (1, [0.125, 0.375], [0.125, 0.0]),
        ] {
            let values: Vec<Vec4> =
                (0..6).map(|k| lean(0.3 - 0.2 * k as f32, 0.1 * k as f32).extend(1.0)).collect();
            let mut stored = Vec::new();
            let line = super::frames::FrameLine { face, at, step };
            frames.store(&case.canvas, &line, &values, &mut stored);
            assert_eq!(stored.len(), values.len());
            for (number, (stored, value)) in stored.iter().zip(&values).enumerate() {
                let [s, t] = [0, 1].map(|k| at[k] + step[k] * number as f32);
                let expected = frames.to_stored(&case.canvas, face, s, t) * value.truncate() + 0.5;
                assert!(stored.truncate().distance(expected) < 1e-6, "{face} {number}: {stored} {expected}");
            }
        }
    }
}
