// The preview's own shader, compiled behind mesh_color_texture.wgsl and mesh_color_texture_indexed.wgsl. What an asset lacks is switched off
// by overrides, so that it is neither sampled nor computed. Its CPU twins: preview/cpu/fragment.rs for the
// fragment stage, preview/shade.rs for the light. Everything is in view space, colors are linear.

// How each slot finds its texture: 0 it has none, 1 by mesh coordinate, 2 + n by texture coordinate set n.
override BASE_COLOR: u32 = 0u;
override METALLIC_ROUGHNESS: u32 = 0u;
override NORMAL: u32 = 0u;
override OCCLUSION: u32 = 0u;
override EMISSIVE: u32 = 0u;
// 0 all of the material, lit; 1 + slot: that slot alone, unlit.
override LOOK: u32 = 0u;
// 0 opaque, 1 tested, 2 blended.
override ALPHA: u32 = 0u;
// A corner's record, in floats; position at 0, normal at 3; TANGENT_AT, MESH_AT and COLOR_AT are 0 where absent.
override STRIDE: u32 = 6u;
override TANGENT_AT: u32 = 0u;
override UV_AT: u32 = 6u;
override UV_SETS: u32 = 0u;
override MESH_AT: u32 = 0u;
override COLOR_AT: u32 = 0u;
// Mesh coordinates: 0 scaled and offset, 1 local, number of the block and class.
override INDEXED: u32 = 0u;

struct Shot {
    projection: mat4x4f,
    // Negative: trilinear.
    forced_level: f32,
}

struct Surface {
    base_color_factor: vec4f,
    // Emissive factor, metallic factor.
    emissive_metallic: vec4f,
    // Roughness factor, normal scale, occlusion strength, alpha cutoff.
    scalars: vec4f,
    // For each slot: where its levels start in `levels`, and how many there are.
    slots: array<vec4u, 5>,
}

@group(0) @binding(0) var<uniform> shot: Shot;
@group(1) @binding(0) var<storage, read> records: array<f32>;
@group(1) @binding(1) var<uniform> surface: Surface;
@group(1) @binding(2) var<storage, read> levels: array<MctLevel>;
@group(1) @binding(3) var base_color_texture: texture_2d<f32>;
@group(1) @binding(4) var metallic_roughness_texture: texture_2d<f32>;
@group(1) @binding(5) var normal_texture: texture_2d<f32>;
@group(1) @binding(6) var occlusion_texture: texture_2d<f32>;
@group(1) @binding(7) var emissive_texture: texture_2d<f32>;
@group(1) @binding(8) var base_color_sampler: sampler;
@group(1) @binding(9) var metallic_roughness_sampler: sampler;
@group(1) @binding(10) var normal_sampler: sampler;
@group(1) @binding(11) var occlusion_sampler: sampler;
@group(1) @binding(12) var emissive_sampler: sampler;
// Of indexed coordinates: the classes, and for each level the grid of each class.
@group(1) @binding(13) var<storage, read> block_classes: array<MctBlockClass>;
@group(1) @binding(14) var<storage, read> block_grids: array<MctBlockGrid>;

// Places are interpolated twice: at the centroid, for values, and at the middle of the pixel, for
// derivatives.
struct Varyings {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(perspective, centroid) position: vec3f,
    @location(1) @interpolate(perspective, centroid) normal: vec3f,
    @location(2) @interpolate(perspective, centroid) tangent: vec4f,
    @location(3) @interpolate(perspective, centroid) mesh: vec4f,
    @location(4) @interpolate(perspective, centroid) uv_01: vec4f,
    @location(5) @interpolate(perspective, centroid) uv_23: vec4f,
    @location(6) @interpolate(perspective, centroid) uv_4: vec2f,
    @location(7) scaled_middle: vec2f,
    @location(8) uv_01_middle: vec4f,
    @location(9) uv_23_middle: vec4f,
    @location(10) uv_4_middle: vec2f,
    // Number and class.
    @location(11) @interpolate(flat) block: vec2u,
    @location(12) @interpolate(perspective, centroid) color: vec4f,
}

fn record_vec2(at: u32) -> vec2f {
    return vec2f(records[at], records[at + 1u]);
}

fn record_vec4(at: u32) -> vec4f {
    return vec4f(record_vec2(at), record_vec2(at + 2u));
}

fn record_uv(corner: u32, uv_set: u32) -> vec2f {
    if uv_set >= UV_SETS {
        return vec2f(0.0);
    }
    return record_vec2(corner + UV_AT + 2u * uv_set);
}

@vertex
fn vertex(@builtin(vertex_index) number: u32) -> Varyings {
    let corner = number * STRIDE;
    var out: Varyings;
    out.position = vec3f(record_vec2(corner), records[corner + 2u]);
    out.clip = shot.projection * vec4f(out.position, 1.0);
    out.normal = vec3f(records[corner + 3u], record_vec2(corner + 4u));
    if TANGENT_AT != 0u {
        out.tangent = record_vec4(corner + TANGENT_AT);
    }
    if MESH_AT != 0u {
        out.mesh = record_vec4(corner + MESH_AT);
    }
    out.color = vec4f(1.0);
    if COLOR_AT != 0u {
        out.color = record_vec4(corner + COLOR_AT);
    }
    if INDEXED != 0u {
        out.block = vec2u(out.mesh.zw);
    }
    out.uv_01 = vec4f(record_uv(corner, 0u), record_uv(corner, 1u));
    out.uv_23 = vec4f(record_uv(corner, 2u), record_uv(corner, 3u));
    out.uv_4 = record_uv(corner, 4u);
    out.scaled_middle = out.mesh.xy;
    out.uv_01_middle = out.uv_01;
    out.uv_23_middle = out.uv_23;
    out.uv_4_middle = out.uv_4;
    return out;
}

// Where a fragment is in its textures: value, and change to the next pixel right and down.
struct Place {
    mesh: vec4f,
    block: vec2u,
    scaled_dx: vec2f,
    scaled_dy: vec2f,
    uv: array<vec2f, 5>,
    uv_dx: array<vec2f, 5>,
    uv_dy: array<vec2f, 5>,
}

fn uv_sets(uv_01: vec4f, uv_23: vec4f, uv_4: vec2f) -> array<vec2f, 5> {
    return array<vec2f, 5>(uv_01.xy, uv_01.zw, uv_23.xy, uv_23.zw, uv_4);
}

fn level_of_detail(lambda: f32) -> f32 {
    return select(lambda, shot.forced_level, shot.forced_level >= 0.0);
}

// log2 of source texels per pixel: what a GPU computes for a texture with mip maps.
fn source_lambda(uv_dx: vec2f, uv_dy: vec2f, size: vec2f) -> f32 {
    return mct_lambda(uv_dx * size, uv_dy * size);
}

fn sample_indexed(slot: u32, image: texture_2d<f32>, image_sampler: sampler, place: Place) -> vec4f {
    let at = MctBlockPlace(place.mesh.xy, place.block.x, block_classes[place.block.y]);
    let lambda = level_of_detail(mct_indexed_lambda(place.scaled_dx, place.scaled_dy, at.shape));
    let pick = mct_pick(lambda, surface.slots[slot].y);
    let first = surface.slots[slot].x;
    let pair = array(levels[first + pick.finer], levels[first + pick.coarser]);
    let class_count = arrayLength(&block_classes);
    let finer = block_grids[pick.finer * class_count + place.block.y];
    let coarser = block_grids[pick.coarser * class_count + place.block.y];
    return mct_sample_indexed_stack(image, image_sampler, at, pick, array(finer, coarser), pair);
}

fn sample_slot(how: u32, slot: u32, image: texture_2d<f32>, image_sampler: sampler, place: Place) -> vec4f {
    if how == 0u {
        return vec4f(1.0);
    }
    if how == 1u && INDEXED != 0u {
        return sample_indexed(slot, image, image_sampler, place);
    }
    if how == 1u {
        let first = surface.slots[slot].x;
        let lambda = level_of_detail(mct_lambda(place.scaled_dx, place.scaled_dy));
        let pick = mct_pick(lambda, surface.slots[slot].y);
        let pair = array(levels[first + pick.finer], levels[first + pick.coarser]);
        return mct_sample_stack(image, image_sampler, place.mesh, pick, pair);
    }
    var sets = place.uv;
    var sets_dx = place.uv_dx;
    var sets_dy = place.uv_dy;
    let uv_set = how - 2u;
    let size = vec2f(textureDimensions(image));
    let lambda = level_of_detail(source_lambda(sets_dx[uv_set], sets_dy[uv_set], size));
    return textureSampleLevel(image, image_sampler, sets[uv_set], lambda);
}

fn srgb_to_linear(encoded: vec3f) -> vec3f {
    let low = encoded / 12.92;
    let high = pow((encoded + 0.055) / 1.055, vec3f(2.4));
    return select(high, low, encoded <= vec3f(0.04045));
}

fn normalize_or(v: vec3f, otherwise: vec3f) -> vec3f {
    let length_squared = dot(v, v);
    if length_squared > 1e-30 {
        return v * inverseSqrt(length_squared);
    }
    return otherwise;
}

const KEY_DIRECTION = vec3f(-0.485, 0.606, 0.631);
const KEY_COLOR = vec3f(0.94, 0.90, 0.84);
const FILL_DIRECTION = vec3f(0.873, 0.087, 0.480);
const FILL_COLOR = vec3f(0.16, 0.19, 0.23);
const SKY_COLOR = vec3f(0.30, 0.32, 0.35);
const GROUND_COLOR = vec3f(0.11, 0.105, 0.10);
const SHOULDER = 0.8;

struct Shaded {
    base_color: vec3f,
    metallic: f32,
    roughness: f32,
    occlusion: f32,
    emissive: vec3f,
    normal: vec3f,
    eye: vec3f,
}

fn direct(shaded: Shaded, direction: vec3f, light: vec3f) -> vec3f {
    let facing = max(dot(shaded.normal, direction), 0.0);
    let halfway = normalize_or(direction + shaded.eye, shaded.normal);
    let alpha = max(shaded.roughness * shaded.roughness, 0.06);
    let shininess = 2.0 / (alpha * alpha) - 2.0;
    let lobe = (shininess + 2.0) / 8.0 * pow(max(dot(shaded.normal, halfway), 1e-4), shininess);
    let reflectance = mix(vec3f(0.04), shaded.base_color, shaded.metallic);
    let diffuse = shaded.base_color * (1.0 - 0.7 * shaded.metallic);
    return light * facing * (diffuse + reflectance * min(lobe, 6.0));
}

fn ambient(shaded: Shaded) -> vec3f {
    let around = mix(GROUND_COLOR, SKY_COLOR, 0.5 + 0.5 * shaded.normal.y);
    let mirrored = 2.0 * dot(shaded.normal, shaded.eye) * shaded.normal - shaded.eye;
    let blur = 0.15 + 0.85 * shaded.roughness;
    let reflected = mix(GROUND_COLOR, SKY_COLOR * 2.0, smoothstep(-blur, blur, mirrored.y));
    let reflectance = mix(vec3f(0.04), shaded.base_color, shaded.metallic);
    let diffuse = shaded.base_color * (1.0 - 0.7 * shaded.metallic);
    return shaded.occlusion * (diffuse * around + reflectance * reflected);
}

fn lit(shaded: Shaded) -> vec3f {
    let light = direct(shaded, KEY_DIRECTION, KEY_COLOR)
        + direct(shaded, FILL_DIRECTION, FILL_COLOR)
        + ambient(shaded)
        + shaded.emissive;
    let over = max(light - SHOULDER, vec3f(0.0));
    let bent = SHOULDER + (1.0 - SHOULDER) * (1.0 - exp(-over / (1.0 - SHOULDER)));
    return min(light, bent);
}

fn mapped_normal(stored: vec3f, scale: f32, normal: vec3f, tangent: vec3f, handedness: f32) -> vec3f {
    let local = (stored * 2.0 - 1.0) * vec3f(scale, scale, 1.0);
    let bitangent = cross(normal, tangent) * handedness;
    return normalize_or(tangent * local.x + bitangent * local.y + normal * local.z, normal);
}

fn fragment_normal(in: Varyings, place: Place, is_front: bool) -> vec3f {
    let facing = select(-1.0, 1.0, is_front);
    let normal = normalize_or(in.normal, vec3f(0.0, 0.0, 1.0));
    if NORMAL == 0u || TANGENT_AT == 0u {
        return normal * facing;
    }
    let stored = sample_slot(NORMAL, 2u, normal_texture, normal_sampler, place).xyz;
    let tangent = normalize_or(in.tangent.xyz, vec3f(1.0, 0.0, 0.0));
    let handedness = select(1.0, -1.0, in.tangent.w < 0.0);
    return facing * mapped_normal(stored, surface.scalars.y, normal, tangent, handedness);
}

fn metallic_roughness(place: Place) -> vec4f {
    return sample_slot(METALLIC_ROUGHNESS, 1u, metallic_roughness_texture, metallic_roughness_sampler, place);
}

fn occlusion(place: Place) -> f32 {
    return sample_slot(OCCLUSION, 3u, occlusion_texture, occlusion_sampler, place).x;
}

fn emissive(place: Place) -> vec3f {
    return sample_slot(EMISSIVE, 4u, emissive_texture, emissive_sampler, place).xyz;
}

// What a flat picture shows where a material has no texture in the channel shown.
const ABSENT = vec3f(0.03);

fn flat_color(in: Varyings, place: Place, base: vec3f, is_front: bool) -> vec3f {
    if LOOK == 1u {
        return base;
    }
    if LOOK == 2u && METALLIC_ROUGHNESS != 0u {
        return srgb_to_linear(metallic_roughness(place).xyz);
    }
    if LOOK == 3u && NORMAL != 0u {
        return srgb_to_linear(fragment_normal(in, place, is_front) * 0.5 + 0.5);
    }
    if LOOK == 4u && OCCLUSION != 0u {
        return srgb_to_linear(vec3f(occlusion(place)));
    }
    if LOOK == 5u && EMISSIVE != 0u {
        return emissive(place);
    }
    return ABSENT;
}

fn lit_color(in: Varyings, place: Place, base: vec3f, is_front: bool) -> vec3f {
    let stored = metallic_roughness(place);
    var shaded: Shaded;
    shaded.base_color = base;
    shaded.metallic = stored.z * surface.emissive_metallic.w;
    shaded.roughness = stored.y * surface.scalars.x;
    shaded.occlusion = 1.0 + surface.scalars.z * (occlusion(place) - 1.0);
    shaded.emissive = emissive(place) * surface.emissive_metallic.xyz;
    shaded.normal = fragment_normal(in, place, is_front);
    shaded.eye = normalize_or(-in.position, vec3f(0.0, 0.0, 1.0));
    return lit(shaded);
}

@fragment
fn fragment(in: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let place = Place(
        in.mesh,
        in.block,
        dpdx(in.scaled_middle),
        dpdy(in.scaled_middle),
        uv_sets(in.uv_01, in.uv_23, in.uv_4),
        uv_sets(dpdx(in.uv_01_middle), dpdx(in.uv_23_middle), dpdx(in.uv_4_middle)),
        uv_sets(dpdy(in.uv_01_middle), dpdy(in.uv_23_middle), dpdy(in.uv_4_middle)),
    );
    let base = sample_slot(BASE_COLOR, 0u, base_color_texture, base_color_sampler, place)
        * in.color * surface.base_color_factor;
    if ALPHA == 1u && base.w < surface.scalars.w {
        discard;
    }
    var color: vec3f;
    if LOOK == 0u {
        color = lit_color(in, place, base.xyz, is_front);
    } else {
        color = flat_color(in, place, base.xyz, is_front);
    }
    let alpha = select(1.0, clamp(base.w, 0.0, 1.0), ALPHA == 2u);
    return vec4f(clamp(color, vec3f(0.0), vec3f(1.0)), alpha);
}
