use std::collections::HashSet;

use glam::Vec3;

use super::{Block, Coordinates, Layout, LayoutRequest, arrange};
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
    arrange(&LayoutRequest {
        canvas,
        resolutions,
        diagonals: &vec![1; canvas.faces.len()],
        level_count: usize::from(resolutions.max()) + 3,
        side_limit,
        coordinates,
    })
}

/// Exponents of many kinds; of quads different ones along the axes where they may be.
fn mixed(canvas: &CanvasMesh, coordinates: Coordinates) -> Resolutions {
    let of_face = |(number, face): (usize, &CanvasFace)| {
        let [r, s] = [number * 7 % 5, number * 11 % 6].map(|exponent| exponent as u8);
        if face.is_triangle() || coordinates == Coordinates::Scaled { [r; 2] } else { [r, s] }
    };
    Resolutions { faces: canvas.faces.iter().enumerate().map(of_face).collect() }
}

const KINDS: [(bool, Coordinates); 4] = [
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
        let layout = layout(&canvas, &mixed(&canvas, coordinates), coordinates, 4096).unwrap();
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
        let layout = layout(&canvas, &mixed(&canvas, coordinates), coordinates, 4096).unwrap();
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
        let resolutions = mixed(&canvas, coordinates);
        let layout = layout(&canvas, &resolutions, coordinates, 4096).unwrap();
        for (face, exponents) in resolutions.faces.iter().enumerate() {
            let count = canvas.faces[face].count();
            if coordinates == Coordinates::Scaled {
                let side = f32::from(1u16 << exponents[0]);
                assert_eq!(layout.offset(face).fract().to_array(), [0.5, 0.5]);
                assert!(
                    (0..count).all(|corner| (layout.corner(face, corner) % side).to_array() == [0.0, 0.0])
                );
            }
            let last = match coordinates {
                Coordinates::Scaled => usize::from(exponents[0]),
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
    let layout = layout(&canvas, &mixed(&canvas, Coordinates::Indexed), Coordinates::Indexed, 8192).unwrap();
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

#[test]
fn a_layout_over_the_limit_says_how_to_mend_it() {
    let canvas = strip(100, true);
    let error = layout(&canvas, &Resolutions::uniform([8; 100]), Coordinates::Scaled, 1024).unwrap_err();
    assert_eq!(error.code, ErrorCode::TextureTooLarge);
    assert!(error.detail.contains("--resolution"), "{}", error.detail);
    assert_eq!(error.limit, Some(1024));
}
