// Mesh color textures: sampling functions for WGSL. Paste this file into a shader module; it declares
// no bindings and needs no extension.
//
// Method: C. Yuksel, "Mesh Color Textures", High Performance Graphics 2017 (cited as MCT).
//
// A corner carries a 4D coordinate, vec4f(scaled, offset), both in texels. Texel centers lie at .5.
//   scaled  attribute _MCT_SCALED: u_s, texels of level 0; halves from level to level
//   offset  attribute _MCT_OFFSET: u_delta, texels of every level; constant over a triangle
// Interpolate it with @interpolate(perspective, centroid) where the target is multisampled: outside its
// triangle a coordinate points at another face's texels. Take derivatives of an interpolant that is not
// centroid, since centroid moves from pixel to pixel along edges.
//
// Every texture is a stack or a set of level images that are not mip levels of one texture: their sizes do
// not halve. Samplers filter linearly and have no mip maps and no anisotropy.
//
// One texture for each level (bind as many as the asset has, sizes from textureDimensions):
//   let pick = mct_pick(mct_lambda(dpdx(scaled), dpdy(scaled)), level_count);
//   let finer = textureSampleLevel(level_a, s, mct_texcoord(mct_place(coordinate, pick.finer), size_a), 0.0);
//   let coarser = textureSampleLevel(level_b, s, mct_texcoord(mct_place(coordinate, pick.coarser), size_b), 0.0);
//   let color = mix(finer, coarser, pick.fraction);
// A level that the file lists under "ranges" is not filtered in sRGB: upload a scaled16 level as 16-bit unorm
// (or as floats) and its codes' bits as half floats for a float16 one, then give the fetch its meaning:
//   let coarser = mct_decode(textureSampleLevel(...), range_b);
// Filter weights sum to 1, so decoding after filtering is decoding before it. Mixing with another level
// comes after that. In one texture for all levels, store such levels decoded, as floats.
//
// All levels in one texture, `table[level]` being where each stands:
//   let pick = mct_pick(mct_lambda(dpdx(scaled), dpdy(scaled)), level_count);
//   let color = mct_sample_stack(stack, s, coordinate, pick, array(table[pick.finer], table[pick.coarser]));

// Where one level stands in a stack, texels of the stack.
struct MctLevel {
    origin: vec2f,
    size: vec2f,
}

// The two levels of a trilinear fetch; `fraction` is the coarser one's weight, 0 to 1.
struct MctPick {
    finer: u32,
    coarser: u32,
    fraction: f32,
}

// What a filtered texel of a level stands for: scale 1 and bias 0 for all but scaled16 levels. Of an image
// without alpha both have 1 and 0 there; of a gray one the same number in red, green and blue.
struct MctRange {
    scale: vec4f,
    bias: vec4f,
}

// The place of a 4D coordinate in the image of `level`, in texels of that image (MCT equation 2):
// u_level = u_s / 2^level + u_delta.
fn mct_place(coordinate: vec4f, level: u32) -> vec2f {
    // 2^-level from its bits: exact on every GPU, which exp2 need not be.
    let shrink = bitcast<f32>((127u - min(level, 126u)) << 23u);
    return coordinate.xy * shrink + coordinate.zw;
}

// The level of detail, log2 of texels of level 0 per pixel, from the screen-space derivatives of `scaled`.
// The larger derivative decides: no aliasing, some blur at grazing angles. Not clamped.
fn mct_lambda(scaled_dx: vec2f, scaled_dy: vec2f) -> f32 {
    let longest_squared = max(dot(scaled_dx, scaled_dx), dot(scaled_dy, scaled_dy));
    return 0.5 * log2(max(longest_squared, 1e-30));
}

// The two levels around `lambda` among `level_count` (at least 1), and the mix between them.
fn mct_pick(lambda: f32, level_count: u32) -> MctPick {
    let last = f32(max(level_count, 1u) - 1u);
    let within = clamp(lambda, 0.0, last);
    let finer = floor(within);
    return MctPick(u32(finer), u32(min(finer + 1.0, last)), within - finer);
}

// The texture coordinate, 0 to 1, of a place in a level that is a texture of its own. `size` in texels.
fn mct_texcoord(place: vec2f, size: vec2f) -> vec2f {
    return place / size;
}

// The texture coordinate of a place of `level` in a stack of levels of `stack_size` texels. The clamp keeps
// the bilinear footprint inside the level, as clamp-to-edge does for a texture of its own.
fn mct_in_stack(place: vec2f, level: MctLevel, stack_size: vec2f) -> vec2f {
    let inside = clamp(place, vec2f(0.5), level.size - 0.5);
    return (level.origin + inside) / stack_size;
}

// The value of a filtered texel of a level with a range: linear light for color, whatever the slot.
fn mct_decode(filtered: vec4f, range: MctRange) -> vec4f {
    return filtered * range.scale + range.bias;
}

// The bilinear value of one level of a stack.
fn mct_sample_level(stack: texture_2d<f32>, stack_sampler: sampler, place: vec2f, level: MctLevel) -> vec4f {
    let stack_size = vec2f(textureDimensions(stack));
    return textureSampleLevel(stack, stack_sampler, mct_in_stack(place, level, stack_size), 0.0);
}

// The trilinear value of a stack; `levels` are the table's entries for `pick.finer` and `pick.coarser`.
fn mct_sample_stack(
    stack: texture_2d<f32>,
    stack_sampler: sampler,
    coordinate: vec4f,
    pick: MctPick,
    levels: array<MctLevel, 2>,
) -> vec4f {
    let finer = mct_sample_level(stack, stack_sampler, mct_place(coordinate, pick.finer), levels[0]);
    let coarser = mct_sample_level(stack, stack_sampler, mct_place(coordinate, pick.coarser), levels[1]);
    return mix(finer, coarser, pick.fraction);
}
