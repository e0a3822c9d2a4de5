use std::collections::HashSet;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};

use super::{Class, Packing, Page, parted};

fn class(cells: [u32; 2], exponents: [u8; 2], lone_count: u8, block_count: u32) -> Class {
    Class { cells, exponents, lone_count, block_count }
}

/// Texels of all blocks at a level. Fails where two meet, or one leaves the image.
fn filled(page: &Page, level: usize) -> Result<u64, TestCaseError> {
    let [width, height] = page.sizes[level];
    let mut taken = HashSet::new();
    for (class, grid) in page.classes.iter().zip(&page.grids[level]) {
        let [columns, rows] = class.footprint(level);
        for number in 0..class.block_count {
            let [x, y] = grid.first_texel(class, level, number);
            prop_assert!(x + columns <= width && y + rows <= height, "level {}: {} {}", level, x, y);
            for texel in (y..y + rows).flat_map(|y| (x..x + columns).map(move |x| [x, y])) {
                prop_assert!(taken.insert(texel), "level {}: {:?} belongs to two blocks", level, texel);
            }
        }
    }
    Ok(taken.len() as u64)
}

/// The classes of a small animal: few blocks, and large ones among them.
fn fox() -> Vec<Class> {
    let quads = [
        ([1, 1], [3, 3], 2),
        ([1, 1], [4, 3], 4),
        ([1, 1], [4, 4], 8),
        ([1, 1], [5, 3], 6),
        ([1, 1], [5, 4], 25),
        ([1, 1], [5, 5], 6),
        ([1, 1], [6, 3], 4),
        ([1, 1], [6, 4], 17),
        ([1, 1], [6, 5], 23),
        ([1, 1], [6, 6], 16),
        ([1, 1], [7, 4], 1),
        ([1, 1], [7, 5], 7),
        ([1, 1], [7, 6], 4),
        ([1, 2], [5, 3], 2),
        ([1, 2], [6, 4], 12),
        ([1, 2], [6, 5], 18),
        ([1, 2], [7, 5], 2),
        ([2, 1], [4, 4], 6),
        ([2, 1], [5, 5], 9),
    ];
    let lone = [(3, 1), (4, 19), (5, 22), (6, 7)];
    let quads = quads.into_iter().map(|(cells, exponents, count)| class(cells, exponents, 0, count));
    quads.chain(lone.map(|(r, count)| class([1, 1], [r; 2], if r > 1 { 2 } else { 1 }, count))).collect()
}

/// Many classes of small blocks, as a budget of texels makes them.
fn coarse() -> Vec<Class> {
    let shapes = (0..5).flat_map(|r| (0..=r).map(move |s| [r, s]));
    let of_shape = |(number, exponents): (usize, [u8; 2])| {
        let count = |share: usize| (400 / (share + number * number) + 1) as u32;
        let cells = [([1, 1], 1), ([1, 2], 3), ([2, 1], 4), ([4, 1], 20)];
        cells.map(|(cells, share)| class(cells, exponents, 0, count(share)))
    };
    let quads = shapes.enumerate().flat_map(of_shape);
    let mut all: Vec<Class> =
        quads.chain((0..4).map(|r| class([1, 1], [r; 2], if r > 1 { 2 } else { 1 }, 40))).collect();
    all.sort_by_key(|class| (class.lone_count, class.cells, class.exponents));
    all
}

/// Two shapes of face alone, and the larger blocks that came of them: few classes, most of them with many blocks.
fn uniform() -> Vec<Class> {
    let quads = [
        ([1, 1], 527),
        ([2, 1], 601),
        ([2, 2], 119),
        ([4, 1], 232),
        ([4, 2], 60),
        ([4, 4], 7),
        ([8, 1], 145),
        ([8, 2], 19),
    ];
    let quads = quads.into_iter().map(|(cells, count)| class(cells, [3, 3], 0, count));
    quads.chain([class([1, 1], [3, 3], 2, 186)]).collect()
}

/// Texels that nobody reads, of how many, by level.
fn unread(page: &Page) -> Vec<[u64; 2]> {
    let of_level = |(level, [width, height]): (usize, &[u32; 2])| {
        let spare = |class: &Class| u64::from(class.spare_texels(level) * class.block_count);
        let spare: u64 = page.classes.iter().map(spare).sum();
        let all = u64::from(width * height);
        [all + spare - filled(page, level).unwrap(), all]
    };
    page.sizes.iter().enumerate().map(of_level).collect()
}

/// At every level, and where few blocks leave little choice too. More than 2 %, at the worst level: where blocks of two lone
/// triangles have near to that spare themselves, and where there are too many classes for all of them to be parted.
#[test]
fn little_is_left_unread() {
    let most = |permille: u64, [unread, all]: [u64; 2]| {
        assert!(unread * 1000 <= all * permille, "{unread} of {all}")
    };
    for (classes, at_worst) in [(fox(), 23), (coarse(), 22), (uniform(), 20)] {
        let by_level = unread(&Page::new(parted(&classes), 9, 4096, Packing::Tight));
        by_level.iter().for_each(|&level| most(at_worst, level));
        most(20, by_level.iter().fold([0; 2], |sum, level| [0, 1].map(|k| sum[k] + level[k])));
    }
}

/// Blocks of one shape that stand at several places leave less empty than those that stand at one.
#[test]
fn parts_leave_less_empty() {
    let all = |classes: &[Class]| -> u64 {
        unread(&Page::new(classes.to_vec(), 9, 4096, Packing::Tight)).iter().map(|level| level[0]).sum()
    };
    let (of_parts, of_wholes) = (all(&parted(&uniform())), all(&uniform()));
    assert!(3 * of_parts < 2 * of_wholes, "{of_parts} and {of_wholes} texels");
}

/// Two lone triangles stand closer where they are down to one segment: all of their block is read.
#[test]
fn blocks_of_two_shrink_with_their_triangles() {
    let two = class([1, 1], [3, 3], 2, 1);
    let footprints: Vec<_> = (0..5).map(|level| two.footprint(level)).collect();
    assert_eq!(footprints, [[12, 9], [8, 5], [6, 3], [4, 2], [4, 2]]);
    assert_eq!([0, 1, 2, 3, 4].map(|level| two.spare_texels(level)), [2, 2, 2, 0, 0]);
    let alone = class([1, 1], [1, 1], 1, 1);
    assert_eq!(
        [0, 1].map(|level| (alone.footprint(level), alone.spare_texels(level))),
        [([3, 3], 1), ([2, 2], 0)]
    );
}

/// The same on one thread and on several.
#[test]
fn threads_change_nothing() {
    let page = |count: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
        pool.install(|| Page::new(fox(), 6, 4096, Packing::Tight))
    };
    let (one, three) = (page(1), page(3));
    assert_eq!((one.sizes, one.grids), (three.sizes, three.grids));
}

/// A limit is kept to while there is room for all, and it is no wider than that where there is not.
#[test]
fn a_limit_is_kept_to() {
    let classes = vec![class([1, 1], [5, 5], 0, 62), class([1, 1], [2, 2], 0, 10)];
    assert!(Page::fits(&classes, 272));
    let page = Page::new(classes.clone(), 3, 272, Packing::Tight);
    assert!(page.sizes[0].into_iter().all(|side| side <= 272), "{:?}", page.sizes);
    assert!(!Page::fits(&classes, 200));
    assert!(Page::new(classes, 3, 200, Packing::Tight).sizes[0].into_iter().any(|side| side > 200));
}

#[test]
fn nothing_takes_next_to_nothing() {
    assert_eq!(Page::new(Vec::new(), 2, 64, Packing::Tight).sizes, [[1, 1]; 2]);
}

fn classes() -> impl Strategy<Value = Vec<Class>> {
    let cells = (0u32..3, 0u32..3).prop_map(|(x, y)| [1 << x, 1 << y]);
    let quads = (cells, 0u8..6, 0u8..6, 1u32..40)
        .prop_map(|(cells, r, s, count)| class(cells, [r.max(s), r.min(s)], 0, count));
    let lone =
        (0u8..5, 1u32..20).prop_map(|(r, count)| class([1, 1], [r; 2], if r > 1 { 2 } else { 1 }, count));
    (prop::collection::vec(quads, 0..12), prop::collection::vec(lone, 0..4)).prop_map(|(quads, lone)| {
        let mut all: Vec<Class> = quads.into_iter().chain(lone).collect();
        all.sort_by_key(|class| (class.lone_count, class.cells, class.exponents));
        all.dedup_by_key(|class| (class.lone_count, class.cells, class.exponents));
        all
    })
}

proptest! {
    #![proptest_config(Config {
        cases: 24,
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..Config::default()
    })]

    /// Parts have the shape of their class and all of its blocks, and there are not too many.
    #[test]
    fn parts_are_the_class(classes in classes(), more in 0u32..2000) {
        let mut classes = classes;
        classes.iter_mut().for_each(|class| class.block_count += more);
        let parts = parted(&classes);
        let entries = |classes: &[Class]| -> usize { classes.iter().map(|class| 1 + usize::from(class.has_two())).sum() };
        prop_assert!(entries(&parts) <= entries(&classes).max(160));
        prop_assert!(parts.iter().all(|part| part.block_count > 0));
        let joined = parts.chunk_by(|a, b| Class { block_count: b.block_count, ..*a } == *b);
        let whole: Vec<Class> = joined
            .map(|parts| Class { block_count: parts.iter().map(|part| part.block_count).sum(), ..parts[0] })
            .collect();
        prop_assert_eq!(whole, classes);
    }

    /// Every block has texels of its own inside the image, whatever the classes.
    #[test]
    fn blocks_of_a_page_never_meet(classes in classes(), is_parted in any::<bool>()) {
        let (classes, packing) =
            if is_parted { (parted(&classes), Packing::Tight) } else { (classes, Packing::Quick) };
        let page = Page::new(classes, 8, 4096, packing);
        for level in 0..8 {
            let count: u64 = page.classes.iter().map(|class| {
                class.footprint(level).into_iter().map(u64::from).product::<u64>() * u64::from(class.block_count)
            }).sum();
            prop_assert_eq!(filled(&page, level)?, count);
        }
    }
}
