//! What a conversion says of models that it changes or refuses.

use super::*;

fn run(text: &str, rung: VertexColors) -> Result<Conversion> {
    let options = Options { vertex_colors: rung, ..Options::default() };
    convert(&Upload::single("model.obj", text.as_bytes().to_vec()), &options, &Limits::default(), &Unwatched)
}

#[test]
fn a_refusal_repeats_what_reading_left_out() {
    let error = run("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0\nf 1 2 3\n", VertexColors::Auto).err().unwrap();
    assert_eq!(error.code, ErrorCode::NothingToConvert);
    assert!(error.detail.contains("none of them has both faces"), "{error}");
    assert!(error.detail.contains("vertices without a color in a file where others have one"), "{error}");
    assert!(error.detail.contains("(model.obj, 1 of them)"), "{error}");
}

#[test]
fn colors_that_are_white_when_clamped_are_taken_and_told() {
    let mut asset = noise_asset(3, 3, Slot::BaseColor);
    let count = asset.meshes[0].primitives[0].positions.len();
    let mut takers = |value: f32| {
        let attribute = Attribute {
            semantic: VERTEX_COLORS.to_owned(),
            component_type: 5126,
            kind: "VEC3".to_owned(),
            normalized: false,
            element_bytes: 12,
            bytes: value.to_le_bytes().repeat(3 * count),
        };
        asset.meshes[0].primitives[0].attributes = vec![attribute];
        let takers = vertex_colors::takers(&asset, VertexColors::Bake);
        let warnings = vertex_colors::warnings(&asset, VertexColors::Bake, &takers);
        (takers.len(), warnings.iter().map(|warning| warning.code.clone()).collect::<Vec<_>>())
    };
    assert_eq!(takers(1.0), (0, vec![]), "white changes nothing");
    assert_eq!(takers(200.0), (1, vec!["clamped_vertex_color".to_owned()]));
}
