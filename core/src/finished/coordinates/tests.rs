use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::*;
use crate::error::ErrorCode;
use crate::finished::{Finished, hand_made};

/// Twice the place of a corner with whole local coordinates, by whole numbers alone.
fn doubled(table: &BlockTable, class: u32, number: u32, local: [i64; 2], level: usize) -> [i64; 2] {
    let BlockClass { exponents, cells, gap, shift } = table.classes[class as usize];
    let columns = i64::from(table.levels[level].columns[class as usize]);
    let origin = table.levels[level].origins[class as usize];
    let number = i64::from(number) + i64::from(table.levels[level].firsts[class as usize]);
    let block = [number - number / columns * columns, number / columns];
    [0, 1].map(|axis| {
        let mut k = 1;
        for _ in level..usize::from(exponents[axis]) {
            k *= 2;
        }
        // A second triangle begins no later than right behind a square of the first one's size.
        let (mut gap, mut shift) = (i64::from(gap[axis]), i64::from(shift[axis]));
        if gap > k + 2 {
            gap = k + 2;
        }
        if shift > k + 1 {
            shift = k + 1;
        }
        let pitch = i64::from(cells[axis]) * k + gap;
        2 * (block[axis] * pitch + local[axis] * k + shift + i64::from(origin[axis])) + 1
    })
}

#[test]
fn every_corner_of_the_sheet_stands_where_the_formula_says() {
    let (_, finished) = hand_made::sheet();
    let (piece, table) = (&finished.primitives[0], hand_made::table());
    let mut seen = std::collections::BTreeSet::new();
    for (number, triangle) in piece.triangles.iter().enumerate() {
        let Anchor::Block { class, number: block } = triangle.anchor else { panic!("indexed") };
        for (corner, level) in (0..3).flat_map(|corner| (0..hand_made::LEVEL_COUNT).map(move |l| (corner, l)))
        {
            let local = triangle.corners[corner].to_array().map(|local| local as i64);
            let wanted = doubled(&table, class, block, local, level).map(|twice| twice as f32 / 2.0);
            assert_eq!(piece.place(number, corner, level).to_array(), wanted, "{triangle:?} at {level}");
            seen.insert((class, block));
        }
    }
    assert_eq!(seen.len(), 7);
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(5), failure_persistence: None, cases: 512, ..ProptestConfig::default()
    })]

    /// Any table whose places a 32-bit float holds gives them exactly.
    #[test]
    fn places_are_exact(
        exponents in [0u8..12, 0u8..12],
        cells in [1u32..5, 1u32..5],
        gap in [1u32..6, 1u32..6],
        shift in [0u32..6, 0u32..6],
        levels in prop::collection::vec((1u32..40, [0u32..9000, 0u32..9000]), 1..15),
        number in 0u32..1000,
        local in [0i64..5, 0i64..5],
    ) {
        let own = BlockClass { exponents, cells, gap, shift: [shift[0] % gap[0], shift[1] % gap[1]] };
        let other = BlockClass { exponents: [20, 0], cells: [3, 1], gap: [1, 1], shift: [0, 0] };
        let levels = levels.iter().map(|&(columns, origin)| TableLevel {
            columns: vec![7, columns],
            firsts: vec![3, origin[0] % 50],
            origins: vec![[1, 2], origin],
        });
        let table = BlockTable { classes: vec![other, own], levels: levels.collect() };
        let level_count = table.levels.len();
        let corners = [Vec2::ZERO, Vec2::new(local[0] as f32, local[1] as f32), Vec2::X];
        let triangle = FinishedTriangle { vertices: [0; 3], corners, anchor: Anchor::Block { class: 1, number } };
        let coordinates = Coordinates::Indexed(Arc::new(table.clone()));
        for level in 0..level_count {
            let wanted = doubled(&table, 1, number, local, level);
            if wanted.iter().all(|&twice| twice < 1 << 24) {
                let found = coordinates.place(&triangle, 1, level);
                prop_assert_eq!([found.x, found.y].map(|at| (2.0 * at) as i64), wanted);
                prop_assert_eq!(coordinates.place_at(&triangle, Vec3::Y, level), found);
            }
        }
        let [a, b, _] = coordinates.texels(&triangle);
        let texels = [0, 1].map(|k| local[k] << exponents[k]);
        prop_assert_eq!((b - a).to_array().map(|at| at as i64), texels);
    }
}

#[test]
fn four_d_places_are_those_of_the_paper() {
    let corners = [Vec2::new(96.0, 64.0), Vec2::new(128.0, 64.0), Vec2::new(96.0, 96.0)];
    let anchor = Anchor::Offset(Vec2::new(2.5, 1.5));
    let triangle = FinishedTriangle { vertices: [0, 1, 2], corners, anchor };
    let of = Coordinates::Scaled;
    assert_eq!(of.place(&triangle, 1, 0), Vec2::new(130.5, 65.5));
    assert_eq!(of.place(&triangle, 0, 5), Vec2::new(5.5, 3.5));
    assert_eq!(of.place_at(&triangle, Vec3::new(0.5, 0.25, 0.25), 3), Vec2::new(15.5, 10.5));
    assert_eq!((of.exponent(&triangle), of.texels(&triangle)), (5, corners));
    assert!(!of.is_extrapolated(&triangle, 5) && of.is_extrapolated(&triangle, 6));
}

#[test]
fn an_indexed_triangle_has_its_class_exponents_and_no_extrapolated_texel() {
    let (_, finished) = hand_made::sheet();
    let piece = &finished.primitives[0];
    let of = |class: u32| {
        let is_own =
            |t: &&FinishedTriangle| matches!(t.anchor, Anchor::Block { class: own, .. } if own == class);
        piece.triangles.iter().find(is_own).unwrap()
    };
    let exponents: Vec<usize> = (0..6).map(|class| piece.coordinates.exponent(of(class))).collect();
    assert_eq!(exponents, [3, 2, 2, 2, 1, 3]);
    assert!(!piece.coordinates.is_extrapolated(of(4), 5));
}

/// The place and the rule of what is said after a change to a sound conversion.
fn refused(change: impl FnOnce(&mut Finished, &mut BlockTable)) -> (String, String) {
    let (_, mut finished) = hand_made::sheet();
    finished.check_coordinates().unwrap();
    let mut table = hand_made::table();
    change(&mut finished, &mut table);
    if finished.primitives[0].coordinates.table().is_some() {
        finished.primitives[0].coordinates = Coordinates::Indexed(Arc::new(table));
    }
    let error = finished.check_coordinates().unwrap_err();
    assert_eq!(error.code, ErrorCode::InvalidModel);
    (error.pointer.unwrap_or_default(), error.detail)
}

fn expect(found: (String, String), below: &str, rule: &str) {
    let pointer = format!("/meshes/0/primitives/0{below}");
    assert!(found.0 == pointer && found.1.contains(rule), "{found:?}");
}

const TABLE: &str = "/extensions/MCT_mesh_color_texture/coordinates";

#[test]
fn tables_that_break_a_rule_are_refused() {
    let class = |number: usize| format!("{TABLE}/classes/{number}");
    let level = |number: usize| format!("{TABLE}/levels/{number}");
    expect(refused(|_, table| table.classes.clear()), &format!("{TABLE}/classes"), "1 to 4096 classes");
    expect(refused(|_, table| table.classes[4].exponents[1] = 21), &class(4), "0 to 20");
    expect(refused(|_, table| table.classes[1].cells[0] = 0), &class(1), "\"cells\" has to be 1 to 65535");
    expect(
        refused(|_, table| table.classes[1].cells[1] = 1 << 16),
        &class(1),
        "\"cells\" has to be 1 to 65535",
    );
    expect(refused(|_, table| table.classes[2].gap[1] = 0), &class(2), "\"gap\" has to be 1 to 65535");
    expect(refused(|_, table| table.classes[3].shift[0] = 4), &class(3), "\"shift\" has to be below \"gap\"");
    let fewer = refused(|_, table| {
        table.levels.pop();
    });
    expect(fewer, &format!("{TABLE}/levels"), "there are 5 levels, and the material's textures have 6");
    let short = refused(|_, table| {
        table.levels[2].columns.pop();
    });
    expect(short, &level(2), "one entry for each of 6 classes");
    expect(refused(|_, table| table.levels[3].origins.push([0; 2])), &level(3), "one entry for each");
    expect(refused(|_, table| table.levels[1].columns[5] = 0), &level(1), "at least 1");
}

#[test]
fn blocks_stay_inside_of_their_images() {
    let level = |number: usize| format!("{TABLE}/levels/{number}");
    let moved = |axis: usize| refused(move |_, table| table.levels[4].origins[4][axis] += 9);
    expect(moved(0), &level(4), "of class 4, block 0 leaves the image of level 4");
    expect(moved(1), &level(4), "of class 4, block 0 leaves the image of level 4");
    // More columns than the image is wide, and a row more than it is high.
    expect(refused(|_, table| table.levels[0].columns[0] = 2), &level(0), "class 0, block 1 leaves");
    expect(
        refused(|_, table| table.levels[5].origins[5] = [u32::MAX; 2]),
        &level(5),
        "class 5, block 0 leaves",
    );
    // Nothing overflows.
    let far = refused(|finished, table| {
        table.classes[4] =
            BlockClass { exponents: [20; 2], cells: [65_535; 2], gap: [65_535; 2], shift: [65_534; 2] };
        finished.primitives[0].triangles[7].anchor = Anchor::Block { class: 4, number: (1 << 24) - 1 };
        table.levels[0].columns[4] = u32::MAX;
    });
    expect(far, &level(0), "of class 4, block 16777215 leaves the image of level 0");
    // By one texel: the largest number counts, with its last texel.
    let (_, finished) = hand_made::sheet();
    let size = finished.textures[0].levels[0].size();
    for axis in 0..2 {
        let cut = refused(|finished, _| {
            let image = &mut finished.textures[0].levels[0];
            [image.width, image.height] =
                std::array::from_fn(|k| if k == axis { size[k] - 1 } else { size[k] });
        });
        expect(cut, &level(0), "leaves the image of level 0");
    }
}

#[test]
fn triangles_that_break_a_rule_are_refused() {
    let block = |class: u32, number: u32| {
        refused(move |finished, _| {
            finished.primitives[0].triangles[2].anchor = Anchor::Block { class, number };
        })
    };
    expect(block(6, 0), "/attributes/_MCT_BLOCK", "triangle 2: there is no class 6, the table has 6");
    expect(
        block(0, 1 << 24),
        "/attributes/_MCT_BLOCK",
        "triangle 2: block numbers have to be below 16777216",
    );
    expect(block(0, 40), &format!("{TABLE}/levels/0"), "class 0, block 40 leaves the image");
    for (corner, value) in [(0, -0.5), (1, 1.5), (2, f32::NAN), (0, f32::INFINITY)] {
        let outside = refused(|finished, _| finished.primitives[0].triangles[3].corners[corner].y = value);
        expect(
            outside,
            "/attributes/_MCT_LOCAL",
            "triangle 3: every value has to be within the block's 1 by 1 faces",
        );
    }
    let other = refused(|finished, _| {
        finished.primitives[0].triangles[1].anchor = Anchor::Offset(Vec2::ZERO);
    });
    expect(other, "", "triangle 1 has coordinates of the other kind");
    let plain = refused(|finished, _| finished.primitives[0].coordinates = Coordinates::Scaled);
    expect(plain, "", "triangle 0 has coordinates of the other kind");
    let mixed = refused(|finished, table| {
        let mut second = finished.primitives[0].clone();
        table.levels[0].origins[0] = [0, 1];
        second.mesh = 1;
        finished.primitives.push(second);
    });
    assert_eq!(mixed.0, format!("/meshes/1/primitives/0{TABLE}"));
    assert!(mixed.1.contains("all primitives of one material"), "{mixed:?}");
}

#[test]
fn what_is_refused_has_no_place() {
    let (_, finished) = hand_made::sheet();
    let piece = &finished.primitives[0];
    for anchor in [
        Anchor::Block { class: 6, number: 0 },
        Anchor::Offset(Vec2::ONE),
        Anchor::Block { class: u32::MAX, number: u32::MAX },
    ] {
        assert!(piece.coordinates.map(anchor, 0).shift.is_nan(), "{anchor:?}");
    }
    assert!(piece.coordinates.map(piece.triangles[0].anchor, hand_made::LEVEL_COUNT).shift.is_nan());
    assert!(Coordinates::Scaled.map(piece.triangles[0].anchor, 0).shift.is_nan());
}
