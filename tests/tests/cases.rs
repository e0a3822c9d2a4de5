//! One test for each golden case (`tests/cases`, remade by `make.py` there).

use meshcolor_tests::cases;

macro_rules! cases {
    ($($(#[$mark:meta])* $name:ident,)*) => {
        $(#[test]
        $(#[$mark])*
        fn $name() {
            cases::run(stringify!($name));
        })*

        const LISTED: &[&str] = &[$(stringify!($name)),*];
    };
}

cases! {
    accessor_interleaved,
    accessor_sparse,
    alpha_all_transparent,
    alpha_blend,
    alpha_mask,
    alpha_no_vote,
    alpha_opaque,
    alpha_unseen_seam,
    bad_accessor_range,
    bad_container,
    bad_extension,
    bad_glb_length,
    bad_image_bomb,
    bad_image_cut_short,
    bad_image_format,
    bad_index,
    bad_infinite_texcoord,
    bad_json,
    bad_mtl_climbs,
    bad_nan_position,
    bad_node_cycle,
    bad_nothing_to_convert,
    bad_obj_index,
    bad_texture_size,
    bad_uri_absolute,
    bad_uri_climbs,
    bad_uri_encoded,
    bad_uri_external,
    bad_uri_file,
    bad_uri_missing,
    bad_zip_climbs,
    coincident_same_way,
    coincident_sheets,
    cut_ends_inside,
    exponents_0_and_6,
    image_1x1,
    image_7_by_3,
    indices_u16,
    indices_u32,
    indices_u8,
    instances,
    jpeg,
    lines_and_plain_material,
    material_over_two_meshes,
    materials_two_in_a_mesh,
    mode_fan,
    mode_strip,
    moebius_strip,
    needle,
    negative_zero,
    normal_black,
    normal_of_no_direction,
    normal_scale_half,
    normal_uv_constant,
    normal_with_tangent,
    normal_without_normals,
    normal_without_tangent,
    normal_zero_area_face,
    obj_concave_quad,
    obj_map_options,
    obj_negative_numbers,
    obj_polygon,
    obj_quad_and_triangle,
    obj_single_quad,
    obj_two_objects,
    obj_v_points_up,
    obj_vertex_colors,
    palette_low_poly,
    png_16_bit,
    png_gray,
    png_gray_alpha,
    png_palette,
    primitives_weld,
    repeated_index,
    scale_far_away,
    scale_tiny,
    seam_painted_hard,
    seam_that_agrees,
    single_triangle,
    skin_morph_animation,
    slots_of_two_sets,
    slots_shared_image,
    texcoord_missing,
    texcoord_set_1,
    texcoords_u16,
    texcoords_u8,
    three_faces_agree,
    three_faces_disagree,
    transform_rotation,
    transform_scale_offset,
    transform_texcoord,
    uv_constant,
    uv_mirrored,
    uv_overlapping,
    uv_thousands_of_tiles_away,
    valence_100,
    valence_3,
    valence_4,
    wrap_clamp,
    wrap_mirror,
    wrap_repeat,
    wrap_tiled_seam,
    zero_area_face,
    zero_length_edge,
    zip_with_a_folder,
    zip_with_an_encoded_name,
}

#[test]
fn every_folder_is_listed_and_every_listed_case_has_a_folder() {
    assert_eq!(cases::names(), LISTED);
}

#[test]
fn the_script_makes_the_same_files() {
    let Some(made) = cases::made_by(&cases::folder().join("make.py")) else { return };
    let kept = cases::files_of_cases(&cases::folder());
    assert_eq!(made.keys().collect::<Vec<_>>(), kept.keys().collect::<Vec<_>>());
    for (name, bytes) in &made {
        assert!(*bytes == kept[name], "{name} is not what make.py writes");
    }
}
