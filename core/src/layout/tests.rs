use std::collections::HashSet;

use glam::{Vec2, Vec3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::{Block, Coordinates, Layout, LayoutRequest, Place, SEPARATION, arrange, scaled};
use crate::colors::Resolutions;
use crate::error::ErrorCode;
use crate::mesh::{CanvasFace, CanvasMesh, Polygons, build};

/// A strip of `count` triangles, or of squares where `quads`.
fn strip(count: u32, quads: bool) -> CanvasMesh {
    let positions: Vec<Vec3> =
        (0..2 * count + 4).map(|k| Vec3::new((k / 2) as f32, (k % 2) as f32, 0.0)).collect();
    let mut faces = (0..count).map(|k| {
        if quads {
            ([2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1], 4)
        } else if k % 2 == 0 {
            ([k, k + 2, k + 1, 0], 3)
        } else {
            ([k, k + 1, k + 2, 0], 3)
        }
    });
    build([Polygons { mesh: 0, primitive: 0, positions: &positions, faces: &mut faces }])
}

fn layout(
    canvas: &CanvasMesh,
    resolutions: &Resolutions,
    coordinates: Coordinates,
    side_limit: u32,
) -> crate::Result<Layout> {
    let layouts = arrange(&[LayoutRequest {
        canvas,
        resolutions,
        diagonals: &vec![1; canvas.faces.len()],
        level_count: usize::from(resolutions.max()) + 3,
        side_limit,
        part_side: side_limit,
        coordinates,
    }]);
    layouts.map(|mut layouts| layouts.remove(0))
}

/// Exponents of many kinds; of quads different ones along the axes.
fn mixed(canvas: &CanvasMesh) -> Resolutions {
    let of_face = |(number, face): (usize, &CanvasFace)| {
        let [r, s] = [number * 7 % 5, number * 11 % 6].map(|exponent| exponent as u8);
        if face.is_triangle() { [r; 2] } else { [r, s] }
    };
    Resolutions { faces: canvas.faces.iter().enumerate().map(of_face).collect() }
}

const KINDS: [(bool, Coordinates); 6] = [
    (false, Coordinates::ScaledInRows),
    (true, Coordinates::ScaledInRows),
    (false, Coordinates::Scaled),
    (true, Coordinates::Scaled),
    (false, Coordinates::Indexed),
    (true, Coordinates::Indexed),
];

/// No texel belongs to two blocks at any level, and every block lies inside the image.
#[test]
fn blocks_never_meet() {
    for (quads, coordinates) in KINDS {
        let canvas = strip(60, quads);
        let layout = layout(&canvas, &mixed(&canvas), coordinates, 4096).unwrap();
        for (level, size) in layout.sizes.iter().enumerate() {
            let mut taken = HashSet::new();
            for block in &layout.blocks {
                let first = layout.first_corner(block, level).floor();
                let end = layout.block_end(block, level);
                assert!(end[0] <= size[0] && end[1] <= size[1]);
                for y in first.y as u32..end[1] {
                    for x in first.x as u32..end[0] {
                        assert!(taken.insert((x, y)), "level {level}: texel {x}, {y} belongs to two blocks");
                    }
                }
            }
        }
    }
}

/// Bands are in order, hold every block once, and no block leaves its band.
#[test]
fn bands_part_the_rows() {
    for (quads, coordinates) in KINDS {
        let canvas = strip(300, quads);
        let layout = layout(&canvas, &mixed(&canvas), coordinates, 4096).unwrap();
        for (level, bands) in layout.bands.iter().enumerate() {
            let mut seen = vec![0; layout.blocks.len()];
            let ends = bands.iter().skip(1).map(|band| band.first_row).chain([layout.sizes[level][1]]);
            assert_eq!(bands[0].first_row, 0);
            for (band, end) in bands.iter().zip(ends) {
                for number in band.blocks.iter().cloned().flatten() {
                    let block = &layout.blocks[number];
                    seen[number] += 1;
                    assert!(layout.first_corner(block, level).y as u32 >= band.first_row);
                    assert!(layout.block_end(block, level)[1] <= end, "level {level}");
                }
            }
            assert!(seen.into_iter().all(|count| count == 1));
        }
    }
}

/// Invariant 4: of 4D coordinates `u_s` is a multiple of the face's side, `u_δ` an integer and a half. With both kinds,
/// up to vertex colors, corners stand on texel centers a side apart.
#[test]
fn samples_stand_on_texel_centers() {
    for (quads, coordinates) in KINDS {
        let canvas = strip(50, quads);
        let resolutions = mixed(&canvas);
        let layout = layout(&canvas, &resolutions, coordinates, 4096).unwrap();
        for (face, exponents) in resolutions.faces.iter().enumerate() {
            let count = canvas.faces[face].count();
            let sides = layout.block(face).exponents.map(|exponent| f32::from(1u16 << exponent));
            if coordinates != Coordinates::Indexed {
                assert_eq!(layout.offset(face).fract().to_array(), [0.5, 0.5]);
                let is_multiple =
                    |corner| (layout.corner(face, corner) % Vec2::from(sides)).to_array() == [0.0, 0.0];
                assert!((0..count).all(is_multiple));
            }
            let last = match coordinates {
                Coordinates::ScaledInRows | Coordinates::Scaled => exponents[0].min(exponents[1]).into(),
                Coordinates::Indexed => layout.level_count() - 1,
            };
            for level in 0..=last {
                let places: Vec<_> = (0..count).map(|corner| layout.place(face, corner, level)).collect();
                assert!(places.iter().all(|place| place.fract().to_array() == [0.5, 0.5]));
                let side = |k: usize| f32::from(1u16 << usize::from(exponents[k]).saturating_sub(level));
                let length = |k: usize| places[k].distance(places[(k + 1) % count]);
                if quads {
                    assert_eq!(
                        [length(0), length(1), length(2), length(3)],
                        [side(0), side(1), side(0), side(1)]
                    );
                } else {
                    let doubled_area = (places[1] - places[0]).perp_dot(places[2] - places[0]).abs();
                    assert_eq!(doubled_area, side(0) * side(0), "a triangle is half its square");
                }
            }
        }
    }
}

/// What the grids leave empty at each level is under two in a hundred, however few blocks a class has.
#[test]
fn grids_leave_little_empty() {
    let canvas = strip(20_000, true);
    let layout = layout(&canvas, &mixed(&canvas), Coordinates::Indexed, 8192).unwrap();
    for (level, [width, height]) in layout.sizes.iter().enumerate() {
        let texels = |block: &Block| {
            let [n, m] = block.exponents.map(|exponent| 1u64 << usize::from(exponent).saturating_sub(level));
            (n + 1) * (m + 1)
        };
        let used: u64 = layout.blocks.iter().map(texels).sum();
        let waste = 1.0 - used as f64 / f64::from(width * height);
        assert!(waste < 0.02, "level {level}: {width} x {height}, {waste}");
    }
}

/// What a packing takes beyond blocks with their separation, as shares: at level 0, and over all levels.
fn waste(layout: &Layout) -> [f64; 2] {
    let padded = |level: usize| {
        let texels = |block: &Block| {
            let [n, m] = block.exponents.map(|exponent| (f64::from(exponent) - level as f64).exp2());
            (n + f64::from(scaled::steps(block.kind))) * (m + f64::from(SEPARATION))
        };
        layout.blocks.iter().map(texels).sum::<f64>()
    };
    let allocated = |level: usize| layout.sizes[level].map(f64::from).into_iter().product::<f64>();
    let levels = 0..layout.level_count();
    let all = 1.0 - levels.clone().map(padded).sum::<f64>() / levels.map(allocated).sum::<f64>();
    [1.0 - padded(0) / allocated(0), all]
}

/// Shelves leave less than rows do, and of a thousand quads of all sizes less than 4 % at level 0 and 10 % over all levels.
#[test]
fn shelves_leave_little_empty() {
    for quads in [false, true] {
        let canvas = strip(2000, quads);
        let with = |coordinates| waste(&layout(&canvas, &mixed(&canvas), coordinates, 8192).unwrap());
        let (rows, shelves) = (with(Coordinates::ScaledInRows), with(Coordinates::Scaled));
        assert!(shelves[1] < rows[1], "{shelves:?}, {rows:?}");
        assert!(!quads || shelves[0] < 0.04 && shelves[1] < 0.1, "{shelves:?}");
    }
}

/// The texels along one axis that filtering between two places may read, centers being whole numbers.
fn texels_between(first: f64, last: f64) -> [i64; 2] {
    let end = if last - first < 1.0 { last.floor() + 1.0 } else { last };
    [first.floor() as i64, end.ceil() as i64]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, rng_seed: RngSeed::Fixed(7), failure_persistence: None, ..ProptestConfig::default() })]

    /// Of every layout, by places of corners alone: each face stands in one block, no two blocks' texels meet at any level
    /// and all lie inside the image; with 4D coordinates a block begins at multiples of its sides.
    #[test]
    fn every_layout_is_sound(
        seeds in prop::collection::vec((0u8..=6, 0u8..=6, 0u8..4), 1..70),
        (quads, coordinates) in prop::sample::select(&KINDS[..]),
        least in 0u8..=4,
    ) {
        let canvas = strip(seeds.len() as u32, quads);
        let exponents = |(r, s, bias): (u8, u8, u8)| {
            // Most are of few sizes, as in models.
            let [r, s] = [r, s].map(|exponent| if bias > 0 { least.max(exponent.min(3)) } else { exponent });
            if quads { [r, s] } else { [r; 2] }
        };
        let resolutions = Resolutions { faces: seeds.into_iter().map(exponents).collect() };
        let layout = layout(&canvas, &resolutions, coordinates, 1 << 14).unwrap();

        let mut faces: Vec<usize> = Vec::new();
        for (number, block) in layout.blocks.iter().enumerate() {
            for face in block.kind.faces() {
                prop_assert_eq!(layout.placements[face].block as usize, number);
                faces.push(face);
            }
            if let Place::Scaled { origin, .. } = block.place {
                prop_assert!((0..2).all(|k| origin[k].is_multiple_of(1 << block.exponents[k])));
            }
        }
        faces.sort_unstable();
        prop_assert!(faces.into_iter().eq(0..canvas.faces.len()));

        for (level, size) in layout.sizes.iter().enumerate() {
            let texels = |block: &Block| -> [[i64; 2]; 2] {
                let places: Vec<_> = (block.kind.faces())
                    .flat_map(|face| (0..canvas.faces[face].count()).map(move |corner| (face, corner)))
                    .map(|(face, corner)| layout.place(face, corner, level).as_dvec2() - 0.5)
                    .collect();
                [0, 1].map(|k| {
                    let least = places.iter().map(|place| place[k]).fold(f64::INFINITY, f64::min);
                    let most = places.iter().map(|place| place[k]).fold(f64::NEG_INFINITY, f64::max);
                    texels_between(least, most)
                })
            };
            let all: Vec<_> = layout.blocks.iter().map(texels).collect();
            for (number, a) in all.iter().enumerate() {
                prop_assert!((0..2).all(|k| a[k][0] >= 0 && a[k][1] < i64::from(size[k])), "level {level}");
                let meets = |b: &[[i64; 2]; 2]| (0..2).all(|k| a[k][0] <= b[k][1] && b[k][0] <= a[k][1]);
                prop_assert!(!all[..number].iter().any(meets), "level {level}: {a:?}");
            }
        }
    }
}

#[test]
fn a_layout_over_the_limit_says_how_to_mend_it() {
    let canvas = strip(100, true);
    let error = layout(&canvas, &Resolutions::uniform([8; 100]), Coordinates::Scaled, 1024).unwrap_err();
    assert_eq!(error.code, ErrorCode::TextureTooLarge);
    assert!(error.detail.contains("--resolution"), "{}", error.detail);
    assert_eq!(error.limit, Some(1024));
}

/// Two materials in parts of a limited size: no texel belongs to two blocks, blocks stay in their bands and parts.
#[test]
fn materials_stand_between_each_other_in_parts() {
    for coordinates in [Coordinates::Scaled, Coordinates::ScaledInRows] {
        let canvases = [strip(60, false), strip(40, true)];
        let resolutions = canvases.each_ref().map(mixed);
        let request = |k: usize| LayoutRequest {
            canvas: &canvases[k],
            resolutions: &resolutions[k],
            diagonals: &[1; 60],
            level_count: 8,
            side_limit: 4096,
            part_side: 64,
            coordinates,
        };
        let layouts = arrange(&[request(0), request(1)]).unwrap();
        let parts = &layouts[0].parts;
        assert!(parts.len() > 1 && *parts == layouts[1].parts);
        for level in 0..8 {
            let mut taken = HashSet::new();
            for layout in &layouts {
                assert_eq!(
                    layout.blocks.iter().flat_map(|block| block.kind.faces()).count(),
                    layout.placements.len()
                );
                for bands in layout.bands[level].windows(2) {
                    for block in
                        bands[0].blocks.iter().cloned().flatten().map(|number| &layout.blocks[number])
                    {
                        assert!(layout.first_texel(block, level)[1] >= bands[0].first_row);
                        assert!(layout.block_end(block, level)[1] <= bands[1].first_row);
                    }
                }
                for block in &layout.blocks {
                    let Place::Scaled { part, .. } = block.place else { unreachable!() };
                    let part = &parts[part as usize];
                    let (first, end) = (layout.first_texel(block, level), layout.block_end(block, level));
                    let [width, height] = part.sizes[level];
                    assert!(width.max(height) <= 64);
                    let rows = part.first_rows[level]..=part.first_rows[level] + height;
                    assert!(end[0] <= width && rows.contains(&first[1]) && rows.contains(&end[1]));
                    let texels = (first[1]..end[1]).flat_map(|y| (first[0]..end[0]).map(move |x| (x, y)));
                    texels.for_each(|texel| assert!(taken.insert(texel), "level {level}: {texel:?}"));
                }
            }
        }
    }
}

#[test]
fn a_face_over_the_side_of_a_part_says_how_to_mend_it() {
    let canvas = strip(1, true);
    let request = LayoutRequest {
        canvas: &canvas,
        resolutions: &Resolutions::uniform([8]),
        diagonals: &[0],
        level_count: 9,
        side_limit: 4096,
        part_side: 256,
        coordinates: Coordinates::Scaled,
    };
    let error = arrange(&[request]).unwrap_err();
    assert_eq!((error.code, error.limit, error.actual), (ErrorCode::TextureTooLarge, Some(256), Some(257)));
    assert!(error.detail.contains("--max-size"), "{}", error.detail);
}
