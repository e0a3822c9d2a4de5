//! Every function of the shipped WGSL against its twin, on random inputs, where there is an adapter.

use glam::{Vec2, Vec4};
use meshcolor::image::{Image, Pixels, Transfer};

use super::adapter::{Job, Random};
use super::*;

const COUNT: usize = 4096;
const LEVEL_COUNT: u32 = 5;
const INPUT_FLOATS: usize = 16;
const OUTPUT_FLOATS: usize = 22;

/// One call of each function; inputs and outputs are rows of floats.
const MAIN: &str = "
@group(0) @binding(0) var<storage, read> inputs: array<array<f32, 16>>;
@group(0) @binding(1) var<storage, read_write> outputs: array<array<f32, 22>>;
@group(0) @binding(2) var<storage, read> table: array<MctLevel>;
@group(0) @binding(3) var stack: texture_2d<f32>;
@group(0) @binding(4) var stack_sampler: sampler;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = inputs[id.x];
    let coordinate = vec4f(i[0], i[1], i[2], i[3]);
    let lambda = mct_lambda(vec2f(i[4], i[5]), vec2f(i[6], i[7]));
    let pick = mct_pick(i[8], u32(i[9]));
    let place = mct_place(coordinate, u32(i[10]));
    let level = MctLevel(vec2f(i[11], i[12]), vec2f(i[13], i[14]));
    let texcoord = mct_texcoord(place, level.size);
    let in_stack = mct_in_stack(place, level, vec2f(textureDimensions(stack)));
    let known = table[u32(i[15])];
    let one = mct_sample_level(stack, stack_sampler, place, known);
    let two = mct_pick(i[8], 5u);
    let both = mct_sample_stack(stack, stack_sampler, coordinate, two, array(table[two.finer], table[two.coarser]));
    let decoded = mct_decode(coordinate, MctRange(vec4f(i[4], i[5], i[6], i[7]), vec4f(i[11], i[12], i[13], i[14])));
    outputs[id.x] = array<f32, 22>(
        place.x, place.y, lambda, f32(pick.finer), f32(pick.coarser), pick.fraction,
        texcoord.x, texcoord.y, in_stack.x, in_stack.y,
        one.x, one.y, one.z, one.w, both.x, both.y, both.z, both.w,
        decoded.x, decoded.y, decoded.z, decoded.w,
    );
}";

fn table() -> [MctLevel; LEVEL_COUNT as usize] {
    let level = |x, y, w, h| MctLevel { origin: Vec2::new(x, y), size: Vec2::new(w, h) };
    [
        level(0.0, 0.0, 40.0, 33.0),
        level(41.0, 0.0, 22.0, 18.0),
        level(41.0, 19.0, 13.0, 11.0),
        level(55.0, 19.0, 8.0, 7.0),
        level(55.0, 27.0, 8.0, 7.0),
    ]
}

/// 64 × 48 texels of 8-bit data, which half floats hold well enough.
fn stack(random: &mut Random) -> Image {
    let codes = (0..64 * 48 * 4).map(|_| random.whole(256.0) as u8).collect();
    Image { width: 64, height: 48, components: 4, pixels: Pixels::U8(codes) }
}

fn inputs(random: &mut Random) -> Vec<[f32; INPUT_FLOATS]> {
    let input = |random: &mut Random| {
        let mut row = [0.0; INPUT_FLOATS];
        row[0] = random.between(0.0, 40.0);
        row[1] = random.between(0.0, 33.0);
        row[2] = random.whole(6.0) + 0.5;
        row[3] = random.whole(6.0) + 0.5;
        let reach = 2.0_f32.powf(random.between(-12.0, 12.0));
        for derivative in &mut row[4..8] {
            *derivative = random.between(-reach, reach);
        }
        row[8] = random.between(-3.0, 9.0);
        row[9] = 1.0 + random.whole(8.0);
        row[10] = random.whole(21.0);
        for place in &mut row[11..15] {
            *place = 1.0 + random.whole(30.0);
        }
        row[15] = random.whole(LEVEL_COUNT as f32);
        row
    };
    (0..COUNT).map(|_| input(random)).collect()
}

fn twins_of(row: &[f32; INPUT_FLOATS], stack: &Image) -> [f32; OUTPUT_FLOATS] {
    let coordinate = Vec4::from_slice(&row[..4]);
    let lambda = mct_lambda(Vec2::new(row[4], row[5]), Vec2::new(row[6], row[7]));
    let pick = mct_pick(row[8], row[9] as u32);
    let place = mct_place(coordinate, row[10] as u32);
    let level = MctLevel { origin: Vec2::new(row[11], row[12]), size: Vec2::new(row[13], row[14]) };
    let texcoord = mct_texcoord(place, level.size);
    let in_stack = mct_in_stack(place, level, Vec2::new(64.0, 48.0));
    let table = table();
    let one = mct_sample_level(stack, Transfer::Linear, place, table[row[15] as usize]);
    let two = mct_pick(row[8], LEVEL_COUNT);
    let levels = [table[two.finer as usize], table[two.coarser as usize]];
    let both = mct_sample_stack(stack, Transfer::Linear, coordinate, two, levels);
    let mut out = [0.0; OUTPUT_FLOATS];
    out[..2].copy_from_slice(&place.to_array());
    out[2..6].copy_from_slice(&[lambda, pick.finer as f32, pick.coarser as f32, pick.fraction]);
    out[6..8].copy_from_slice(&texcoord.to_array());
    out[8..10].copy_from_slice(&in_stack.to_array());
    out[10..14].copy_from_slice(&one.to_array());
    out[14..18].copy_from_slice(&both.to_array());
    let range = MctRange { scale: Vec4::from_slice(&row[4..8]), bias: Vec4::from_slice(&row[11..15]) };
    out[18..22].copy_from_slice(&mct_decode(coordinate, range).to_array());
    out
}

/// The adapter's answers; `None` where there is no adapter.
fn on_adapter(inputs: &[[f32; INPUT_FLOATS]], stack: &Image) -> Option<Vec<[f32; OUTPUT_FLOATS]>> {
    let rows: Vec<f32> = table().iter().flat_map(|l| [l.origin.x, l.origin.y, l.size.x, l.size.y]).collect();
    let job = Job {
        wgsl: [crate::WGSL, MAIN].concat(),
        input: bytemuck::cast_slice(inputs),
        output_byte_count: inputs.len() * OUTPUT_FLOATS * 4,
        stack,
        tables: &[(2, bytemuck::cast_slice(&rows))],
        workgroup_count: (inputs.len() / 64) as u32,
    };
    let floats = job.run()?;
    Some(floats.chunks_exact(OUTPUT_FLOATS).map(|row| std::array::from_fn(|i| row[i])).collect())
}

#[test]
fn wgsl_and_its_twins_agree() {
    let mut random = Random(7);
    let stack = stack(&mut random);
    let inputs = inputs(&mut random);
    let Some(answers) = on_adapter(&inputs, &stack) else {
        return println!("skipped: wgsl_and_its_twins_agree (no Vulkan adapter)");
    };
    // Places are exact to an ulp or two; logarithms a little less; filtered values carry the 8-bit weights
    // of hardware samplers (1/256 twice) and half-float texels.
    let tolerance = |output: usize| match output {
        0..2 => 1e-5,
        2 => 1e-4,
        6..10 => 1e-5,
        10..18 => 0.01,
        18.. => 1e-5,
        _ => 0.0,
    };
    for (row, answer) in inputs.iter().zip(&answers) {
        let expected = twins_of(row, &stack);
        for (output, (answer, expected)) in answer.iter().zip(expected).enumerate() {
            assert!(
                (answer - expected).abs() <= tolerance(output) * expected.abs().max(1.0),
                "output {output}: {answer}, the twin says {expected}, of {row:?}"
            );
        }
    }
}

#[test]
fn places_halve_from_level_to_level() {
    let coordinate = Vec4::new(96.0, 64.0, 2.5, 1.5);
    let places: Vec<_> = (0..7).map(|level| mct_place(coordinate, level)).collect();
    assert_eq!(places[0], Vec2::new(98.5, 65.5));
    assert_eq!(places[5], Vec2::new(5.5, 3.5));
    assert_eq!(mct_place(coordinate, u32::MAX), coordinate.zw());
}

#[test]
fn lambda_is_clamped_to_the_levels_there_are() {
    assert_eq!(mct_pick(-2.0, 5), MctPick { finer: 0, coarser: 1, fraction: 0.0 });
    assert_eq!(mct_pick(2.25, 5), MctPick { finer: 2, coarser: 3, fraction: 0.25 });
    assert_eq!(mct_pick(40.0, 5), MctPick { finer: 4, coarser: 4, fraction: 0.0 });
    assert_eq!(mct_pick(1.0, 0), MctPick { finer: 0, coarser: 0, fraction: 0.0 });
    assert_eq!(mct_pick(f32::NAN, 5).finer, 0);
}
