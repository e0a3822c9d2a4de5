use std::collections::BTreeMap;

use glam::{Vec2, Vec3};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};

use super::classes::with_few_classes;
use super::copy::Channel;
use super::texels::FaceTexels;
use super::turn::Turn;
use super::{Block, PackOptions, Packed, Painted, pack};
use crate::colors::{Resolutions, level_count};
use crate::error::ErrorCode;
use crate::image::{Image, Pixels};
use crate::layout::{Class, Coordinates, Layout, LayoutRequest, Packing, arrange};
use crate::mesh::{CanvasMesh, Polygons, build};

/// A sheet of `side` by `side` squares around the origin. `starts`: by square, which corner comes first and whether it
/// is wound the other way; the first `split_count` squares are two triangles each.
fn sheet(side: u32, starts: &[(u32, bool)], split_count: usize) -> CanvasMesh {
    let middle = 0.5 * side as f32;
    let positions: Vec<Vec3> = (0..(side + 1) * (side + 1))
        .map(|k| Vec3::new((k % (side + 1)) as f32 - middle, (k / (side + 1)) as f32 - middle, 0.0))
        .collect();
    let mut faces = Vec::new();
    for cell in 0..side * side {
        let a = cell / side * (side + 1) + cell % side;
        let (start, is_reversed) = starts[cell as usize % starts.len()];
        let mut ring = [a, a + 1, a + side + 2, a + side + 1];
        if is_reversed {
            ring.reverse();
        }
        ring.rotate_left(start as usize % 4);
        let [a, b, c, d] = ring;
        if (cell as usize) < split_count {
            faces.extend([([a, b, c, 0], 3), ([a, c, d, 0], 3)]);
        } else {
            faces.push((ring, 4));
        }
    }
    let mut faces = faces.into_iter();
    build([Polygons { mesh: 0, primitive: 0, positions: &positions, faces: &mut faces }])
}

struct Sheet {
    canvas: CanvasMesh,
    resolutions: Resolutions,
    layout: Layout,
    levels: Vec<Image>,
}

impl Sheet {
    /// Paints `color` of the place on the sheet and of the level.
    fn new(canvas: CanvasMesh, exponents: Vec<[u8; 2]>, color: impl Fn(Vec2, usize) -> u8) -> Self {
        let resolutions = Resolutions { faces: exponents };
        let level_count = level_count(&canvas, &resolutions);
        let request = LayoutRequest {
            canvas: &canvas,
            resolutions: &resolutions,
            diagonals: &vec![1; canvas.faces.len()],
            level_count,
            side_limit: 4096,
            part_side: 4096,
            coordinates: Coordinates::Indexed,
        };
        let layout = arrange(&[request]).unwrap().remove(0);
        let levels = (0..level_count).map(|level| {
            let [width, height] = layout.sizes[level];
            let mut codes = vec![0; (width * height) as usize];
            for face in 0..canvas.faces.len() {
                let at =
                    |corner: usize| canvas.positions[canvas.faces[face].vertices[corner] as usize].truncate();
                let place = |corner: usize| layout.place(face, corner, level);
                for [s, t] in points(&canvas, &resolutions, face, level) {
                    let texel = across(place, &canvas, face, s, t);
                    codes[texel.y as usize * width as usize + texel.x as usize] =
                        color(across(at, &canvas, face, s, t), level);
                }
            }
            Image { width, height, components: 1, pixels: Pixels::U8(codes) }
        });
        let levels = levels.collect();
        Self { canvas, resolutions, layout, levels }
    }

    fn packed(&self, shares: bool) -> Packed {
        pack(&[self.painted()], PackOptions { shares, max_side: 4096, packing: Packing::Tight }).unwrap()
    }

    fn painted(&self) -> Painted<'_> {
        Painted { canvas: &self.canvas, layout: &self.layout, images: vec![&self.levels] }
    }
}

/// The points of a face's grid at a level, on its unit domain.
fn points(canvas: &CanvasMesh, resolutions: &Resolutions, face: usize, level: usize) -> Vec<[f32; 2]> {
    let [n, m] = resolutions.faces[face].map(|exponent| 1u32 << usize::from(exponent).saturating_sub(level));
    let all = (0..=m).flat_map(|j| (0..=n).map(move |i| (i, j)));
    let is_triangle = canvas.faces[face].is_triangle();
    all.filter(|(i, j)| !is_triangle || i + j <= n)
        .map(|(i, j)| [i as f32 / n as f32, j as f32 / m as f32])
        .collect()
}

/// What corners have, at `(s, t)` of a face.
fn across(of: impl Fn(usize) -> Vec2, canvas: &CanvasMesh, face: usize, s: f32, t: f32) -> Vec2 {
    let last = canvas.faces[face].count() - 1;
    of(0) + s * (of(1) - of(0)) + t * (of(last) - of(0))
}

/// Reads every point of every face from the new images as a viewer does, and compares.
fn is_unchanged(sheets: &[&Sheet], packed: &Packed) -> Result<(), TestCaseError> {
    let channels: Vec<Channel<'_>> =
        sheets.iter().map(|sheet| Channel { layout: &sheet.layout, levels: &sheet.levels }).collect();
    let parts: Vec<Vec<Image>> = (0..packed.pages.len()).map(|part| packed.images(part, &channels)).collect();
    let code = |image: &Image, place: Vec2| match &image.pixels {
        Pixels::U8(codes) => codes[place.y as usize * image.width as usize + place.x as usize],
        Pixels::U16(_) | Pixels::F32(_) => unreachable!(),
    };
    for (sheet, spots) in sheets.iter().zip(&packed.spots) {
        for (level, old) in sheet.levels.iter().enumerate() {
            for (face, spot) in spots.iter().enumerate() {
                let page = &packed.pages[spot.part as usize];
                let class = &page.classes[spot.class as usize];
                let [x, y] = page.grids[level][spot.class as usize].first_texel(class, level, spot.number);
                let [n, m] = class.segments(level);
                let shift = match n {
                    _ if !spot.is_second => 0,
                    1 => 2,
                    _ => 3,
                };
                let first = Vec2::new((x + shift) as f32, y as f32);
                let place = |corner: usize| {
                    let [x, y] = spot.corners[corner];
                    first + Vec2::new((x * n) as f32 + 0.5, (y * m) as f32 + 0.5)
                };
                for [s, t] in points(&sheet.canvas, &sheet.resolutions, face, level) {
                    let was =
                        across(|corner| sheet.layout.place(face, corner, level), &sheet.canvas, face, s, t);
                    let is = across(place, &sheet.canvas, face, s, t);
                    let [was, is] = [code(old, was), code(&parts[spot.part as usize][level], is)];
                    prop_assert_eq!(was, is, "level {}, face {}, {} {}", level, face, s, t);
                }
            }
        }
    }
    Ok(())
}

#[test]
fn turns_follow_each_other() {
    for (one, two) in Turn::all().flat_map(|one| Turn::all().map(move |two| (one, two))) {
        for point in [[0, 0], [3, 0], [1, 2], [0, 5]] {
            let size = [3, 5];
            let both = one.then(two).point(point, size);
            assert_eq!(both, two.point(one.point(point, size), one.pair(size)));
        }
    }
}

/// Two lone triangles with their border texels have texels of their own, all of their block but what is spare.
#[test]
fn two_triangles_fill_their_block() {
    let class = Class { cells: [1, 1], exponents: [5, 5], lone_count: 2, block_count: 1 };
    for level in 0..7 {
        let [width, height] = class.footprint(level);
        let texels = |is_second: bool| {
            let face = FaceTexels::new([0, 0], class.segments(level), width, true, is_second);
            face.rows().flatten().collect::<Vec<usize>>()
        };
        let mut all = [texels(false), texels(true)].concat();
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count, "level {level}: both have a texel");
        assert!(all.last().is_some_and(|&last| last < (width * height) as usize));
        assert_eq!(count as u32 + class.spare_texels(level), width * height, "level {level}");
    }
}

/// Sixteen squares with one picture over all of them are one block that has each line once.
#[test]
fn what_goes_on_over_edges_is_one_block() {
    let resolutions = vec![[2, 2]; 16];
    let canvas = sheet(4, &[(0, false), (1, false), (3, true), (2, true)], 0);
    let gradient = |at: Vec2, _: usize| (at.x * 20.0 + at.y * 7.0 + 128.0) as u8;
    let sheet = Sheet::new(canvas, resolutions, gradient);
    let packed = sheet.packed(true);
    assert_eq!(packed.pages[0].sizes[0], [17, 17]);
    assert_eq!(packed.pages[0].sizes[2], [5, 5]);
    assert_eq!((packed.savings.joined_count, packed.savings.shared_count), (16, 0));
    is_unchanged(&[&sheet], &packed).unwrap();
}

/// The six sides of a cube, with what is the same everywhere on them.
fn cube() -> Sheet {
    let positions: Vec<Vec3> =
        (0..8u8).map(|k| Vec3::new((k & 1).into(), (k >> 1 & 1).into(), (k >> 2).into())).collect();
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut faces = sides.into_iter().map(|side| (side, 4));
    let canvas = build([Polygons { mesh: 0, primitive: 0, positions: &positions, faces: &mut faces }]);
    Sheet::new(canvas, vec![[2, 2]; 6], |_, level| level as u8)
}

/// Blocks by the number of their faces along each axis.
fn shapes(packed: &Packed) -> BTreeMap<[u32; 2], u32> {
    let mut shapes = BTreeMap::new();
    for class in packed.pages.iter().flat_map(|page| &page.classes) {
        *shapes.entry(class.cells).or_default() += class.block_count;
    }
    shapes
}

/// Sides of a block may have any number of faces.
#[test]
fn five_by_three_squares_are_one_block() {
    let rows = sheet(5, &[(0, false), (1, true), (2, false)], 0);
    let is_in = |face: &usize| face / 5 < 3;
    let positions = rows.positions.clone();
    let mut faces = (0..25).filter(is_in).map(|face| (rows.faces[face].vertices, 4));
    let canvas = build([Polygons { mesh: 0, primitive: 0, positions: &positions, faces: &mut faces }]);
    let sheet = Sheet::new(canvas, vec![[1, 1]; 15], |at, _| (at.x * 20.0 + at.y * 7.0 + 128.0) as u8);
    let packed = sheet.packed(false);
    assert_eq!(shapes(&packed), BTreeMap::from([([5, 3], 1)]));
    is_unchanged(&[&sheet], &packed).unwrap();
}

/// No corner of a cube can be inside of a block, and a row around it would have to meet itself. Two rows of three take
/// least.
#[test]
fn a_cube_is_two_rows_of_three() {
    let cube = cube();
    let packed = cube.packed(false);
    assert_eq!(shapes(&packed), BTreeMap::from([([3, 1], 2)]));
    is_unchanged(&[&cube], &packed).unwrap();
}

/// What has come apart so that there are fewer classes still has every face.
#[test]
fn blocks_come_apart_where_there_are_too_many_classes() {
    let exponents = |face: usize| [[1, 1], [2, 2], [3, 3]][face / 5 % 3];
    let sheet = Sheet::new(sheet(5, &[(0, false)], 0), (0..25).map(exponents).collect(), |_, _| 1);
    let painted = sheet.painted();
    let all = || super::blocks(0, &painted, &[None; 25]);
    let counts = |blocks: &[Block]| {
        let mut counts: BTreeMap<([u32; 2], [u8; 2]), usize> = BTreeMap::new();
        for block in blocks {
            *counts.entry((block.patch.cells, block.exponents)).or_default() += block.patch.faces.len();
        }
        counts
    };
    // Five rows of five. Those of the finest two save more than those of the others together.
    let rows = [1, 2, 3].map(|exponent| ([5, 1], [exponent; 2]));
    assert_eq!(counts(&all()), BTreeMap::from([(rows[0], 10), (rows[1], 10), (rows[2], 5)]));
    let few = counts(&with_few_classes(all(), 4));
    assert_eq!(few, BTreeMap::from([(([1, 1], [1; 2]), 10), (rows[1], 10), (([1, 1], [3; 2]), 5)]));
    assert_eq!(counts(&with_few_classes(all(), 0)).keys().filter(|(cells, _)| *cells != [1, 1]).count(), 0);
}

/// Tiles and mirrored halves need their texels once, unless that is switched off.
#[test]
fn what_repeats_is_stored_once() {
    let tile = |at: Vec2, _: usize| {
        let [x, y] = at.to_array().map(|at| (at.rem_euclid(1.0) * 4.0).round() % 4.0);
        (x * 50.0 + y * y * 7.0) as u8
    };
    let starts = [(0, false), (1, false), (2, false), (3, false)];
    let tiles = Sheet::new(sheet(4, &starts, 0), vec![[2, 2]; 16], tile);
    let packed = tiles.packed(true);
    assert_eq!((packed.savings.shared_count, packed.pages[0].sizes[0]), (15, [5, 5]));
    is_unchanged(&[&tiles], &packed).unwrap();
    assert_eq!(tiles.packed(false).savings.shared_count, 0);

    let mirrored = |at: Vec2, _: usize| (at.x.abs() * 40.0 + at.y * 9.0 + 60.0) as u8;
    let halves = Sheet::new(sheet(4, &[(0, false)], 0), vec![[2, 1]; 16], mirrored);
    let packed = halves.packed(true);
    assert_eq!((packed.savings.shared_count, packed.savings.joined_count), (8, 8));
    is_unchanged(&[&halves], &packed).unwrap();
}

/// A texel that differs at one level keeps the two tiles that show it from using the others' block.
#[test]
fn every_level_counts() {
    let shared = |different_level: usize| {
        let tile = |at: Vec2, level: usize| {
            let is_different = level == different_level && at == Vec2::new(0.0, 1.0);
            if is_different { 9 } else { (at.rem_euclid(Vec2::ONE).length() * 90.0) as u8 }
        };
        Sheet::new(sheet(2, &[(0, false)], 0), vec![[2, 2]; 4], tile).packed(true).savings.shared_count
    };
    assert_eq!([shared(usize::MAX), shared(0), shared(2)], [3, 1, 1]);
}

/// No two faces alike.
fn noise(at: Vec2, level: usize) -> u8 {
    ((at.x * 12.9 + at.y * 78.2 + level as f32).sin() * 43758.5).rem_euclid(256.0) as u8
}

/// What is too large for one image stands in several, none of them larger than asked for.
#[test]
fn parts_fit_and_lose_nothing() {
    let faces = Sheet::new(sheet(4, &[(0, false)], 3), vec![[5, 5]; 19], noise);
    let whole = faces.packed(true);
    assert_eq!(whole.pages.len(), 1);
    for max_side in [70, 100, 130] {
        let packed =
            pack(&[faces.painted()], PackOptions { shares: true, max_side, packing: Packing::Tight })
                .unwrap();
        assert!(packed.pages.iter().all(|page| page.sizes[0].iter().all(|&side| side <= max_side)));
        assert!(packed.pages.len() > 1 && packed.pages.len() <= 19, "{}", packed.pages.len());
        is_unchanged(&[&faces], &packed).unwrap();
    }
    let error = pack(&[faces.painted()], PackOptions { shares: true, max_side: 16, packing: Packing::Tight })
        .unwrap_err();
    assert_eq!((error.code, error.limit), (ErrorCode::TextureTooLarge, Some(16)));
}

/// Materials in one set of images, the one with fewer levels too.
#[test]
fn materials_stand_together() {
    let fine = Sheet::new(sheet(3, &[(1, false)], 4), vec![[3, 3]; 13], noise);
    let coarse = Sheet::new(sheet(2, &[(2, true)], 1), vec![[1, 1]; 5], noise);
    let packed = pack(
        &[fine.painted(), coarse.painted()],
        PackOptions { shares: true, max_side: 4096, packing: Packing::Tight },
    )
    .unwrap();
    assert_ne!(fine.levels.len(), coarse.levels.len());
    assert_eq!((packed.pages.len(), packed.pages[0].sizes.len()), (1, fine.levels.len()));
    is_unchanged(&[&fine, &coarse], &packed).unwrap();
}

proptest! {
    #![proptest_config(Config { cases: 64, rng_seed: RngSeed::Fixed(7), failure_persistence: None, ..Config::default() })]

    /// Whatever is shared and joined, every face reads what was painted for it, and needs no more texels.
    #[test]
    fn nothing_that_is_read_changes(
        starts in prop::collection::vec((0u32..4, any::<bool>()), 9),
        split_count in 0usize..9,
        exponents in prop::collection::vec((0u8..3, 0u8..3), 9),
        are_equal in any::<bool>(),
        period in prop::sample::select(vec![1.0f32, 1.5, 3.0]),
        steps in 1u8..20,
    ) {
        let canvas = sheet(3, &starts, split_count);
        let exponents: Vec<[u8; 2]> = canvas.faces.iter().enumerate().map(|(number, face)| {
            let (r, s) = exponents[if are_equal { 0 } else { number % 9 }];
            if face.is_triangle() { [r; 2] } else { [r, s] }
        }).collect();
        let color = |at: Vec2, _: usize| {
            let at = (at - period * (at / period).round()).abs();
            (at.dot(Vec2::new(3.0, 2.0)) * f32::from(steps)) as u8
        };
        let sheet = Sheet::new(canvas, exponents, color);
        for shares in [false, true] {
            let packed = sheet.packed(shares);
            is_unchanged(&[&sheet], &packed)?;
        }
    }
}
