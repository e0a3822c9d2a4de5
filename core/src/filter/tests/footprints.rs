//! Filters over an area: which levels they read, and where.

use std::f32::consts::FRAC_1_SQRT_2;

use glam::{Vec2, Vec3, Vec4};

use super::{Case, LEVELS, grid, noise, plane, sheet};
use crate::colors::{LevelNumbering, Resolutions};
use crate::filter::{Footprint, Level, MeshColors, Triangles};

/// An axis of so many samples of level 0 in a direction of the face.
fn axis(direction: Vec2, samples: f32, exponents: [u8; 2]) -> Vec2 {
    direction * samples / Vec2::new(f32::from(exponents[0]).exp2(), f32::from(exponents[1]).exp2())
}

/// Directions at a right angle on a triangle of equal sides.
const ACROSS: [Vec2; 2] = [Vec2::X, Vec2::new(-0.577_350_26, 1.154_700_5)];

#[test]
fn mip_maps_go_by_the_longer_axis() {
    for case in Case::all() {
        case.with(&noise, Triangles::Linear, |colors| {
            for (face, at) in (0..4).flat_map(|face| case.places(face).into_iter().map(move |at| (face, at)))
            {
                let exponents = case.resolutions.faces[face];
                for level in 0..LEVELS {
                    let long = axis(Vec2::Y, (level as f32).exp2(), exponents);
                    let short = axis(Vec2::X, 0.3, exponents);
                    for axes in [[long, short], [short, long], [long, Vec2::ZERO]] {
                        let found = colors.mip_mapped(face, at, Footprint { axes });
                        assert_eq!(found, colors.linear(face, at, level), "face {face}, level {level}");
                    }
                }
                let between = Footprint { axes: [axis(Vec2::X, 3.0, exponents), Vec2::ZERO] };
                let wanted = colors.linear(face, at, 1).lerp(colors.linear(face, at, 2), 3f32.log2() - 1.0);
                assert!((colors.mip_mapped(face, at, between) - wanted).abs().max_element() < 1e-5);
                let ends = [(0.0, 0), (f32::INFINITY, LEVELS - 1), (f32::NAN, 0)];
                for (size, level) in ends {
                    let found = colors.trilinear(face, at, size.log2());
                    assert_eq!(found, colors.linear(face, at, level));
                }
            }
        });
    }
}

#[test]
fn round_footprints_are_mip_mapped() {
    for case in Case::all() {
        case.with(&noise, Triangles::Linear, |colors| {
            for (face, at) in (0..4).flat_map(|face| case.places(face).into_iter().map(move |at| (face, at)))
            {
                let is_triangle = case.canvas.faces[face].is_triangle();
                let across = if is_triangle { ACROSS } else { [Vec2::X, Vec2::Y] };
                for size in [0.0, 0.7, 1.0, 2.9, 16.0, 500.0] {
                    // The first a hair longer: rounding must not make two probes of one.
                    let axes = [across[0] * (1.0 + 1e-6), across[1] * (1.0 + 2e-6)];
                    let footprint =
                        Footprint { axes: axes.map(|to| axis(to, size, case.resolutions.faces[face])) };
                    let found = colors.anisotropic(face, at, footprint);
                    assert_eq!(found, colors.mip_mapped(face, at, footprint), "face {face} {at}, {size}");
                }
            }
        });
    }
}

/// Stripes seen from a low angle along them stay stripes; mip maps make them gray.
#[test]
fn long_footprints_keep_what_lies_across() {
    let case = Case::new(sheet(), Resolutions::uniform([5, 5, 5, 5]));
    let stripes = |_: Vec3, _: usize| Vec4::splat(0.5);
    let numberings: Vec<_> = (0..LEVELS)
        .map(|level| LevelNumbering::new(&case.canvas, &case.topology, &case.resolutions, level))
        .collect();
    let values: Vec<Vec<Vec4>> = (numberings.iter())
        .map(|numbering| {
            let mut values = case.values(numbering, &stripes);
            if numbering.level == 0 {
                for ((i, j), _) in grid(numbering, 3) {
                    let tap = numbering.tap(3, i, j);
                    values[tap.samples[0] as usize] = Vec4::splat((i % 2) as f32);
                }
            }
            values
        })
        .collect();
    let levels: Vec<_> =
        numberings.iter().zip(&values).map(|(numbering, values)| Level { numbering, values }).collect();
    let colors = MeshColors::new(&levels, Triangles::Linear).unwrap();
    for (column, at) in [(7, Vec2::new(7.0 / 32.0, 0.5)), (8, Vec2::new(8.0 / 32.0, 0.47))] {
        let long = axis(Vec2::Y, 11.0, [5, 5]);
        for short in [1.0, 0.8] {
            let axes = [axis(Vec2::X, short, [5, 5]), long];
            let found = colors.anisotropic(3, at, Footprint { axes });
            assert!((found.x - (column % 2) as f32).abs() < 1e-5, "{found}");
            assert_eq!(colors.mip_mapped(3, at, Footprint { axes }).x, 0.5);
        }
        // At a slant the probes cross stripes, and their mean is gray.
        let slanted = axis(Vec2::splat(FRAC_1_SQRT_2), 11.0, [5, 5]);
        let axes = [axis(Vec2::new(-FRAC_1_SQRT_2, FRAC_1_SQRT_2), 0.8, [5, 5]), slanted];
        let gray = colors.anisotropic(3, at, Footprint { axes }).x;
        assert!((gray - 0.5).abs() < 0.1, "{gray}");
    }
}

/// Of a function that is linear on the face, the mean along an axis is its value in the middle of what is inside.
#[test]
fn footprints_end_where_the_face_does() {
    let case = Case::new(sheet(), Resolutions::uniform([4, 4, 4, 4]));
    let inside = |face: usize, at: Vec2| {
        at.min_element() >= -1e-6
            && if face < 2 { at.x + at.y <= 1.0 + 1e-6 } else { at.max_element() <= 1.0 + 1e-6 }
    };
    case.with(&plane, Triangles::Linear, |colors| {
        for (face, at) in (0..4).flat_map(|face| case.places(face).into_iter().map(move |at| (face, at))) {
            for long in [Vec2::new(0.9, 0.0), Vec2::new(0.0, -0.7), Vec2::new(0.5, 0.6), Vec2::new(-0.8, 0.6)]
            {
                let found = colors.anisotropic(face, at, Footprint { axes: [long * 0.1, long] });
                let steps = (-2000..=2000).map(|step| step as f32 / 4000.0);
                let mut kept = steps.filter(|part| inside(face, at + long * *part));
                let low = kept.next().unwrap();
                let middle = 0.5 * (low + kept.next_back().unwrap_or(low));
                let wanted = plane(case.position(face, at + long * middle), 0);
                assert!(
                    (found - wanted).abs().max_element() < 2e-3,
                    "{face} {at} {long}: {found}, not {wanted}"
                );
            }
        }
    });
}
