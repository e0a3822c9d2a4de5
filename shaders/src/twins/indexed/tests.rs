//! Every function of the shipped WGSL for indexed coordinates against its twin, on random inputs, where
//! there is an adapter; and the twin against the core.

use std::sync::Arc;

use meshcolor::finished::{Anchor, Coordinates, TableLevel};
use meshcolor::image::Pixels;

use super::super::adapter::{Job, Random};
use super::super::mct_pick;
use super::*;

const COUNT: usize = 4096;
const LEVEL_COUNT: u32 = 5;
const INPUT_FLOATS: usize = 10;
const OUTPUT_FLOATS: usize = 9;

/// One call of each function; inputs and outputs are rows of floats.
const MAIN: &str = "
@group(0) @binding(0) var<storage, read> inputs: array<array<f32, 10>>;
@group(0) @binding(1) var<storage, read_write> outputs: array<array<f32, 9>>;
@group(0) @binding(2) var<storage, read> table: array<MctLevel>;
@group(0) @binding(3) var stack: texture_2d<f32>;
@group(0) @binding(4) var stack_sampler: sampler;
@group(0) @binding(5) var<storage, read> classes: array<MctBlockClass>;
@group(0) @binding(6) var<storage, read> grids: array<MctBlockGrid>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = inputs[id.x];
    let number = u32(i[2]);
    let class_number = u32(i[3]);
    let level = u32(i[4]);
    let at = MctBlockPlace(vec2f(i[0], i[1]), number, classes[class_number]);
    let class_count = arrayLength(&classes);
    let place = mct_indexed_place(at, grids[level * class_count + class_number], level);
    let segments = mct_block_segments(at.shape, level);
    let lambda = mct_indexed_lambda(vec2f(i[5], i[6]), vec2f(i[7], i[8]), at.shape);
    let pick = mct_pick(i[9], 5u);
    let pair = array(
        grids[pick.finer * class_count + class_number],
        grids[pick.coarser * class_count + class_number],
    );
    let both = array(table[pick.finer], table[pick.coarser]);
    let color = mct_sample_indexed_stack(stack, stack_sampler, at, pick, pair, both);
    outputs[id.x] = array<f32, 9>(
        place.x, place.y, f32(segments.x), f32(segments.y), lambda, color.x, color.y, color.z, color.w,
    );
}";

/// Classes of many shapes, and levels of grids of no meaning.
fn table(random: &mut Random) -> BlockTable {
    let classes: Vec<BlockClass> = (0..7)
        .map(|_| {
            let gap = [1 + random.whole(5.0) as u32, 1 + random.whole(3.0) as u32];
            BlockClass {
                exponents: [random.whole(5.0) as u8, random.whole(5.0) as u8],
                cells: [1 + random.whole(3.0) as u32, 1 + random.whole(3.0) as u32],
                gap,
                shift: gap.map(|gap| random.whole(gap as f32) as u32),
            }
        })
        .collect();
    let levels = (0..LEVEL_COUNT).map(|_| TableLevel {
        columns: classes.iter().map(|_| 1 + random.whole(6.0) as u32).collect(),
        firsts: classes.iter().map(|_| random.whole(9.0) as u32).collect(),
        origins: classes.iter().map(|_| [random.whole(20.0) as u32, random.whole(20.0) as u32]).collect(),
    });
    let levels = levels.collect();
    BlockTable { classes, levels }
}

fn stack_levels() -> [MctLevel; LEVEL_COUNT as usize] {
    let level = |x, y, w, h| MctLevel { origin: Vec2::new(x, y), size: Vec2::new(w, h) };
    [
        level(0.0, 0.0, 40.0, 33.0),
        level(41.0, 0.0, 22.0, 18.0),
        level(41.0, 19.0, 13.0, 11.0),
        level(55.0, 19.0, 8.0, 7.0),
        level(55.0, 27.0, 8.0, 7.0),
    ]
}

fn inputs(random: &mut Random, table: &BlockTable) -> Vec<[f32; INPUT_FLOATS]> {
    let input = |random: &mut Random| {
        let class = random.whole(table.classes.len() as f32);
        let cells = table.classes[class as usize].cells;
        let reach = 2.0_f32.powf(random.between(-12.0, 6.0));
        let mut row = [0.0; INPUT_FLOATS];
        row[0] = random.between(0.0, cells[0] as f32);
        row[1] = random.between(0.0, cells[1] as f32);
        row[2] = random.whole(40.0);
        row[3] = class;
        row[4] = random.whole(LEVEL_COUNT as f32);
        for derivative in &mut row[5..9] {
            *derivative = random.between(-reach, reach);
        }
        row[9] = random.between(-2.0, 7.0);
        row
    };
    (0..COUNT).map(|_| input(random)).collect()
}

fn twins_of(row: &[f32; INPUT_FLOATS], table: &MctBlockTable, stack: &Image) -> [f32; OUTPUT_FLOATS] {
    let (class, level) = (row[3] as usize, row[4] as u32);
    let at = MctBlockPlace {
        local: Vec2::new(row[0], row[1]),
        number: row[2] as u32,
        shape: table.classes[class],
    };
    let place = mct_indexed_place(at, table.grid(class, level), level);
    let segments = mct_block_segments(at.shape, level);
    let lambda = mct_indexed_lambda(Vec2::new(row[5], row[6]), Vec2::new(row[7], row[8]), at.shape);
    let pick = mct_pick(row[9], LEVEL_COUNT);
    let grids = [pick.finer, pick.coarser].map(|level| table.grid(class, level));
    let levels = [pick.finer, pick.coarser].map(|level| stack_levels()[level as usize]);
    let color = mct_sample_indexed_stack((stack, Transfer::Linear), at, pick, grids, levels);
    let [x, y] = [segments.x as f32, segments.y as f32];
    [place.x, place.y, x, y, lambda, color.x, color.y, color.z, color.w]
}

#[test]
fn wgsl_and_its_twins_agree() {
    let mut random = Random(11);
    let codes = (0..64 * 48 * 4).map(|_| random.whole(256.0) as u8).collect();
    let stack = Image { width: 64, height: 48, components: 4, pixels: Pixels::U8(codes) };
    let table = table(&mut random);
    let inputs = inputs(&mut random, &table);
    let table = MctBlockTable::new(&table);
    let levels: Vec<f32> =
        stack_levels().iter().flat_map(|l| [l.origin.x, l.origin.y, l.size.x, l.size.y]).collect();
    let (classes, grids) = (table.class_words(), table.grid_words());
    let job = Job {
        wgsl: [crate::WGSL, crate::WGSL_INDEXED, MAIN].concat(),
        input: bytemuck::cast_slice(&inputs),
        output_byte_count: inputs.len() * OUTPUT_FLOATS * 4,
        stack: &stack,
        tables: &[
            (2, bytemuck::cast_slice(&levels)),
            (5, bytemuck::cast_slice(&classes)),
            (6, bytemuck::cast_slice(&grids)),
        ],
        workgroup_count: (inputs.len() / 64) as u32,
    };
    let Some(answers) = job.run() else {
        return println!("skipped: indexed wgsl_and_its_twins_agree (no Vulkan adapter)");
    };
    // Filtered values carry the 8-bit weights of hardware samplers.
    let tolerance = |output: usize| match output {
        0..2 => 1e-6,
        2..4 => 0.0,
        4 => 1e-4,
        _ => 0.01,
    };
    for (row, answer) in inputs.iter().zip(answers.chunks_exact(OUTPUT_FLOATS)) {
        for (output, (answer, expected)) in answer.iter().zip(twins_of(row, &table, &stack)).enumerate() {
            assert!(
                (answer - expected).abs() <= tolerance(output) * expected.abs().max(1.0),
                "output {output}: {answer}, the twin says {expected}, of {row:?}"
            );
        }
    }
}

#[test]
fn the_twin_says_what_the_core_says() {
    let mut random = Random(12);
    let table = table(&mut random);
    let as_held = MctBlockTable::new(&table);
    let coordinates = Coordinates::Indexed(Arc::new(table.clone()));
    for row in inputs(&mut random, &table) {
        let (class, number, level) = (row[3] as u32, row[2] as u32, row[4] as u32);
        let local = Vec2::new(row[0], row[1]);
        let shape = as_held.classes[class as usize];
        let place = MctBlockPlace { local, number, shape };
        let of_core = coordinates.map(Anchor::Block { class, number }, level as usize);
        assert_eq!(
            mct_indexed_place(place, as_held.grid(class as usize, level), level),
            of_core.place(local)
        );
    }
    assert_eq!(as_held.class_words().len() * 32 + as_held.grid_words().len() * 16, table.byte_count());
}

#[test]
fn lambda_weighs_both_axes_by_their_own_texels() {
    let shape =
        MctBlockClass { exponents: UVec2::new(5, 1), cells: UVec2::ONE, gap: UVec2::ONE, shift: UVec2::ZERO };
    assert_eq!(mct_indexed_lambda(Vec2::X / 8.0, Vec2::Y / 8.0, shape), 2.0);
    assert_eq!(mct_indexed_lambda(Vec2::ZERO, Vec2::Y * 2.0, shape), 2.0);
    assert_eq!(mct_block_segments(shape, 3), UVec2::new(4, 1));
    assert_eq!(mct_block_segments(shape, 20), UVec2::ONE);
}
