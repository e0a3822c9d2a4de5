// Mesh color textures with indexed coordinates: sampling functions for WGSL. Paste this file behind
// mesh_color_texture.wgsl, whose levels, ranges and stacks it uses; it declares no bindings and needs no
// extension either.
//
// A corner names its block instead of its place, and each level lays the blocks of a class out as a grid.
//   block  attribute _MCT_BLOCK: number of the block, and its class; constant over a triangle
//   local  attribute _MCT_LOCAL: place in the block, counted in faces
// Hand on vec2u(block) with @interpolate(flat), and local with @interpolate(perspective, centroid) where the
// target is multisampled. Take derivatives of an interpolant of local that is not centroid.
//
// The table is the primitive's "coordinates", the same for all primitives of a material. Put it into uniforms:
//   classes[n]                         MctBlockClass of class n, from r, s, cells, gap, shift
//   grids[level * class_count + n]     MctBlockGrid of class n at that level, from columns, first and origin
// They take 32 bytes a class and 16 for each of its levels.
//
// One texture for each level (bind as many as the asset has, sizes from textureDimensions):
//   let at = MctBlockPlace(local, block.x, classes[block.y]);
//   let pick = mct_pick(mct_indexed_lambda(dpdx(local), dpdy(local), at.shape), level_count);
//   let a = mct_indexed_place(at, grids[pick.finer * class_count + block.y], pick.finer);
//   let b = mct_indexed_place(at, grids[pick.coarser * class_count + block.y], pick.coarser);
//   let finer = textureSampleLevel(level_a, s, mct_texcoord(a, size_a), 0.0);
//   let coarser = textureSampleLevel(level_b, s, mct_texcoord(b, size_b), 0.0);
//   let color = mix(finer, coarser, pick.fraction);
// Levels with ranges are decoded by mct_decode as with other coordinates.
//
// All levels in one texture, `table[level]` being where each stands:
//   let pair = array(grids[pick.finer * class_count + block.y], grids[pick.coarser * class_count + block.y]);
//   let both = array(table[pick.finer], table[pick.coarser]);
//   let color = mct_sample_indexed_stack(stack, s, at, pick, pair, both);

// Blocks of one shape. 32 bytes, as in a uniform array.
struct MctBlockClass {
    // r along x and s along y: a face has 2^r by 2^s segments at level 0.
    exponents: vec2u,
    // Faces along each axis.
    cells: vec2u,
    // Texels from the end of the last face to the next block: at a level whose faces have k segments, k + 2 at most.
    gap: vec2u,
    // Texels from the start of the block to its first face, k + 1 at most.
    shift: vec2u,
}

// Where one level has the blocks of a class. 16 bytes, as in a uniform array.
struct MctBlockGrid {
    // First texel of the grid.
    origin: vec2u,
    // Blocks in a row.
    columns: u32,
    // Blocks of other classes that stand in the grid before this one's.
    first: u32,
}

// What a fragment knows of its block: the local coordinate there, its number, and its class.
struct MctBlockPlace {
    local: vec2f,
    number: u32,
    shape: MctBlockClass,
}

// Segments of a face at `level`: k = (2^max(r - level, 0), 2^max(s - level, 0)).
fn mct_block_segments(shape: MctBlockClass, level: u32) -> vec2u {
    return vec2u(1u) << (max(shape.exponents, vec2u(level)) - level);
}

// The place of a local coordinate in the image of `level`, in texels of that image:
// u_level = (m mod C, m div C) * (cells * k + min(gap, k + 2)) + local * k + min(shift, k + 1) + 0.5 + origin,
// m = first + number.
// `grid` is the table's entry for the class at this level.
fn mct_indexed_place(at: MctBlockPlace, grid: MctBlockGrid, level: u32) -> vec2f {
    let segments = mct_block_segments(at.shape, level);
    let number = grid.first + at.number;
    let block = vec2u(number % grid.columns, number / grid.columns);
    let pitch = at.shape.cells * segments + min(at.shape.gap, segments + 2u);
    let first = block * pitch + min(at.shape.shift, segments + 1u) + grid.origin;
    return at.local * vec2f(segments) + (vec2f(first) + 0.5);
}

// The level of detail, log2 of texels of level 0 per pixel, from the screen-space derivatives of `local`.
// The larger derivative decides, as in mct_lambda. Not clamped.
fn mct_indexed_lambda(local_dx: vec2f, local_dy: vec2f, shape: MctBlockClass) -> f32 {
    let segments = vec2f(mct_block_segments(shape, 0u));
    return mct_lambda(local_dx * segments, local_dy * segments);
}

// The trilinear value of a stack; `grids` are the table's entries for the class, and `levels` those of the
// stack, for `pick.finer` and `pick.coarser`.
fn mct_sample_indexed_stack(
    stack: texture_2d<f32>,
    stack_sampler: sampler,
    at: MctBlockPlace,
    pick: MctPick,
    grids: array<MctBlockGrid, 2>,
    levels: array<MctLevel, 2>,
) -> vec4f {
    let finer = mct_sample_level(stack, stack_sampler, mct_indexed_place(at, grids[0], pick.finer), levels[0]);
    let coarser = mct_sample_level(stack, stack_sampler, mct_indexed_place(at, grids[1], pick.coarser), levels[1]);
    return mix(finer, coarser, pick.fraction);
}
