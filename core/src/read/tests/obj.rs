//! OBJ and MTL: faces, indices, materials, and hostile lines (B9 of the abuse list).

use glam::{Vec2, Vec3, Vec4};

use super::*;
use crate::asset::{AlphaMode, Primitive, Slot};
use crate::image::WrapMode;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn read_text(text: &str) -> Result<Asset> {
    read_bytes(text.as_bytes().to_vec())
}

fn first(asset: &Asset) -> &Primitive {
    &asset.meshes[0].primitives[0]
}

fn corners(asset: &Asset) -> Vec<Vec<u32>> {
    first(asset).faces.iter().map(|face| face.corners().to_vec()).collect()
}

#[test]
fn quads_stay_and_indices_count_both_ways() {
    for face in ["f 1 2 3 4", "f -4 -3 -2 -1", "f 1/ 2/ 3/ 4/", "f 1 2 \\\n 3 4", "f 1 2 3 4 # tail"] {
        let asset = read_text(&format!("{SQUARE}{face}\n")).expect(face);
        assert_eq!(corners(&asset), [[0, 1, 2, 3]], "{face}");
        assert_eq!(first(&asset).positions[2], Vec3::new(1.0, 1.0, 0.0), "{face}");
    }
    let windows = format!("{SQUARE}f 1 2 3\nf 1 3 4\n").replace('\n', "\r\n");
    assert_eq!(corners(&read_text(&windows).unwrap()), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn a_quad_with_a_side_of_no_length_is_two_triangles() {
    // The fifth vertex is where the first is.
    for (face, expected) in
        [("f 1 2 3 5", vec![vec![0, 1, 2], vec![0, 2, 3]]), ("f 1 2 5 3", vec![vec![0, 1, 2, 3]])]
    {
        assert_eq!(
            corners(&read_text(&format!("{SQUARE}v 0 0 -0.0\n{face}\n")).unwrap()),
            expected,
            "{face}"
        );
    }
}

#[test]
fn corners_that_repeat_the_one_before_are_left_out() {
    for (face, expected) in [
        ("f 2 3 3 4", vec![vec![0, 1, 2]]),
        ("f 1 2 3 4 4", vec![vec![0, 1, 2, 3]]),
        ("f 1 1 2 3 4 1", vec![vec![0, 1, 2, 3]]),
        ("f 1 2 2", vec![vec![0, 1, 1]]),
        ("f 1 1 1 1", vec![vec![0, 0, 0], vec![0, 0, 0]]),
    ] {
        let asset = read_text(&format!("{SQUARE}{face}\n")).unwrap();
        assert_eq!(corners(&asset), expected, "{face}");
    }
    // With other coordinates it is another corner.
    let asset = read_text(&format!("{SQUARE}vt 0 0\nvt 1 1\nf 1/1 2/1 3/1 3/2\n")).unwrap();
    assert_eq!(corners(&asset), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn vertices_are_distinct_corners_in_first_use_order() {
    let text = format!(
        "{SQUARE}vt 0 0\nvt 1 0.25\nvn 0 0 2\nvn 0 1 0\nf 3/1/1 1/2/1 2/1/1\nf 3/1/1 2/1/1 4/1/2\nf 3/2/1 2/1/1 4/1/2\n"
    );
    let asset = read_text(&text).unwrap();
    assert_eq!(corners(&asset), [[0, 1, 2], [0, 2, 3], [4, 2, 3]]);
    let primitive = first(&asset);
    assert_eq!(primitive.positions[0], primitive.positions[4]);
    assert_eq!(primitive.texcoords[0][1], Vec2::new(1.0, 0.75), "v runs downwards");
    assert_eq!(primitive.normals[..4], [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::Y]);
}

#[test]
fn corners_without_a_part_get_one_and_are_counted() {
    let text = format!("{SQUARE}vt 0.5 0.5\nvn 0 1 0\nf 1/1/1 2/1/1 3/1/1\nf 1 3 4\n");
    let asset = read_text(&text).unwrap();
    let primitive = first(&asset);
    assert_eq!(primitive.texcoords[0].len(), 6);
    assert_eq!((primitive.texcoords[0][0], primitive.texcoords[0][3]), (Vec2::splat(0.5), Vec2::ZERO));
    assert_eq!((primitive.normals[0], primitive.normals[3]), (Vec3::Y, Vec3::Z));
    let counts: Vec<_> = asset.warnings.iter().map(|w| (w.code.as_str(), w.count)).collect();
    assert_eq!(counts, [("missing_texcoord", 3), ("zero_normal", 3)]);
}

#[test]
fn objects_are_meshes_and_materials_are_primitives() {
    let text = format!(
        "{SQUARE}f 1 2 3\no first\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 2 3\nf 1 3 4\no empty\no second\nf 1 2 3\n\
         o first\nusemtl red\nf 1 3 4\ng group\ns off\n"
    );
    let asset = read_files(&[("folder/scene.obj", text.as_bytes())]).unwrap();
    let primitives = |mesh: &crate::asset::Mesh| -> Vec<_> {
        mesh.primitives.iter().map(|p| (p.material, p.faces.len())).collect()
    };
    let shape: Vec<_> = asset.meshes.iter().map(|mesh| (mesh.name.as_str(), primitives(mesh))).collect();
    let expected = [
        ("scene", vec![(None, 1)]),
        ("first", vec![(Some(0), 2), (Some(1), 2)]),
        ("second", vec![(Some(1), 1)]),
    ];
    assert_eq!(shape, expected);
    let json = &asset.document.json;
    assert_eq!(json["scenes"][0]["nodes"], json!([0, 1, 2]));
    assert_eq!(json["meshes"][1]["primitives"], json!([{ "material": 0 }, { "material": 1 }]));
    assert_eq!(json["materials"][0]["name"], "red");
    assert_eq!(asset.instances.len(), 3);
    assert_eq!(asset.warnings, [], "without a library no material is missed");
}

#[test]
fn vertex_colors_are_an_attribute_where_all_have_them() {
    let colored = "v 0 0 0 1 0 0.5\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1 1\n";
    let asset = read_text(&format!("{colored}f 1 2 3\n")).unwrap();
    let color = &first(&asset).attributes[0];
    assert_eq!((color.semantic.as_str(), color.kind.as_str(), color.bytes.len()), ("COLOR_0", "VEC3", 36));
    assert_eq!((first(&asset).material, asset.materials.len()), (Some(0), 1), "what the colors are of");
    let component = |at: usize| f32::from_le_bytes(color.bytes[4 * at..4 * at + 4].try_into().unwrap());
    assert_eq!((component(0), component(1)), (1.0, 0.0));
    assert!((component(2) - 0.214_041).abs() < 1e-5, "sRGB 0.5 in linear light");
    let asset = read_text(&format!("{colored}v 1 1 1\nf 1 2 3\n")).unwrap();
    assert!(first(&asset).attributes.is_empty());
    assert_eq!((asset.warnings[0].code.as_str(), asset.warnings[0].count), ("partial_vertex_colors", 1));
    assert!(read_text("v 1 2 3 4 5\n").is_err());
}

#[test]
fn what_vertex_colors_lose_is_told() {
    let asset = read_text("v 0 0 0 255 0.5 -1\nv 1 0 0 1 1 1 0.5\nv 0 1 0 0 0 200 1\nf 1 2 3\n").unwrap();
    let told = |code: &str| asset.warnings.iter().find(|known| known.code == code).map(|known| known.count);
    assert_eq!((told("clamped_color"), told("ignored_alpha")), (Some(2), Some(1)));
    assert!(first(&asset).vertex_colors().unwrap().iter().all(|color| color.max_element() <= 1.0));
    assert_eq!(first(&asset).unbounded_color_count(), 0);
}

#[test]
fn materials_come_from_all_libraries() {
    let obj = "mtllib my lib.mtl\nmtllib b.mtl c.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl n\nf 1 2 3\n\
        usemtl lost\nf 1 2 3\n";
    let m = "newmtl m\nKd 0.5 0.5 0.5\nd 0.25\nPr 0.3\nPm 0.9\nKe 2 0 0\nmap_Kd -s 2 3 1 -o 0.5 0.25 -clamp on base color.png\n\
        norm -bm 0.5 normal.png\nmap_Bump bump.png\nmap_d alpha.png\nNs 10\nunknown\n";
    let n = "newmtl n\nKd 0.1 0.2 0.3\nTr 0  illum 2\nmap_Ke sub/glow.png\n";
    let (base, normal, glow) = (png(2, 2), png(3, 3), png(4, 4));
    let asset = read_files(&[
        ("f/m.obj", obj.as_bytes()),
        ("f/my lib.mtl", m.as_bytes()),
        ("f/b.mtl", b"newmtl unused\nmap_Kd missing.png\n"),
        ("f/c.mtl", n.as_bytes()),
        ("f/base color.png", &base),
        ("f/normal.png", &normal),
        ("f/sub/glow.png", &glow),
    ])
    .unwrap();
    let [m, n, lost] = &asset.materials[..] else { panic!("three materials") };
    assert_eq!(m.base_color_factor, Vec4::new(1.0, 1.0, 1.0, 0.25));
    assert_eq!((m.roughness_factor, m.metallic_factor, m.alpha_mode), (0.3, 0.9, AlphaMode::Blend));
    assert_eq!(m.emissive_factor, Vec3::X);
    let slot = m.slot(Slot::BaseColor).unwrap();
    assert_eq!((slot.wrap.s, slot.transform.scale), (WrapMode::ClampToEdge, Vec2::new(2.0, 3.0)));
    // v upwards: 0.25 + 3 * 0.1 = 0.55; v downwards 0.9 must become 0.45.
    let moved = slot.transform.apply(Vec2::new(0.0, 0.9));
    assert!((moved - Vec2::new(0.5, 0.45)).length() < 1e-5, "{moved}");
    assert_eq!((m.slot(Slot::Normal).unwrap().image, m.normal_scale), (1, 0.5));
    assert_eq!(n.base_color_factor, Vec4::new(0.1, 0.2, 0.3, 1.0));
    assert_eq!(n.slot(Slot::Emissive).unwrap().image, 2);
    assert_eq!(n.emissive_factor, Vec3::ONE);
    assert_eq!(lost.base_color_factor, Vec4::ONE);
    let mut codes: Vec<_> = asset.warnings.iter().map(|w| (w.code.as_str(), w.count)).collect();
    codes.sort_unstable();
    let expected =
        [("clamped_color", 1), ("ignored_map", 2), ("ignored_statement", 1), ("unknown_material", 1)];
    assert_eq!(codes[..4], expected);

    let json = &asset.document.json;
    assert_eq!(json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
    let transform = &json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"];
    assert_eq!(transform["KHR_texture_transform"]["scale"], json!([2.0, 3.0]));
    assert_eq!(json["extensionsUsed"], json!(["KHR_texture_transform"]));
    assert_eq!(json["images"].as_array().unwrap().len(), 3);
    assert_eq!(json["textures"][0], json!({ "sampler": 0, "source": 0 }));
    assert_eq!(json["samplers"][0]["wrapS"], 33071);
}

#[test]
fn missing_files_are_named() {
    let obj = format!("{SQUARE}mtllib a.mtl\nusemtl m\nf 1 2 3\n");
    let error = read_files(&[("m.obj", obj.as_bytes())]).unwrap_err();
    assert_eq!((error.code, error.pointer.as_deref()), (ErrorCode::MissingResource, Some("m.obj:5")));
    assert!(error.detail.contains("\"a.mtl\""), "{error}");
    let files: [(&str, &[u8]); 2] =
        [("m.obj", obj.as_bytes()), ("a.mtl", b"newmtl m\nmap_Kd -clamp off t.png\n")];
    let error = read_files(&files).unwrap_err();
    assert_eq!((error.code, error.pointer.as_deref()), (ErrorCode::MissingResource, Some("a.mtl:2")));
    assert!(error.detail.contains("\"t.png\""), "{error}");
    let image = [files[0], files[1], ("t.png", b"\x89PNG\r\n\x1a\n....")];
    assert_eq!(read_files(&image).unwrap_err().pointer.as_deref(), Some("a.mtl:2"));
}

#[test]
fn hostile_statements_name_their_line() {
    let statements = [
        "v 1e400 0 0",
        "v nan 0 0",
        "v inf 0 0",
        "v 0 0",
        "v 1e10 0 0",
        "v one 2 3",
        "v 0 0 0 0 0 0 0 0",
        "vt 1e7",
        "vt",
        "vn 1 2",
        "f 1 2",
        "f 0 1 2",
        "f 1 2 5",
        "f -5 1 2",
        "f 1 2 99999999999999999999",
        "f 1 2 4294967296",
        "f 1/1 2/1 3/1",
        "f 1//1 2 3",
        "f 1/2/3/4 2 3",
        "f /1 2 3",
        "f a b c",
        "mtllib",
    ];
    for statement in statements {
        let error = read_text(&format!("{SQUARE}{statement}\nf 1 2 3\n")).expect_err(statement);
        assert_eq!(
            (error.code, error.pointer.as_deref()),
            (ErrorCode::InvalidModel, Some("model:5")),
            "{statement}: {error}"
        );
    }
    let long = format!("{SQUARE}v {} 0 0\nf 1 2 3\n", "1".repeat(1 << 20));
    assert!(read_text(&long).unwrap_err().detail.len() < 300);
    for empty in ["v 1 2 3\n", "# nothing"] {
        assert_eq!(read_text(empty).unwrap_err().code, ErrorCode::NothingToConvert);
    }
}

#[test]
fn unknown_statements_are_counted() {
    let asset = read_text(&format!("{SQUARE}l 1 2\ncurv 1\nweird\nf 1 2 3\n")).unwrap();
    assert_eq!((asset.warnings[0].code.as_str(), asset.warnings[0].count), ("ignored_statement", 3));
    assert_eq!(asset.warnings[0].pointer, "model:5");
}

#[test]
fn mtl_files_are_parsed_with_care() {
    for mtl in [
        "Kd 1 1 1\n",
        "newmtl m\nKd 1 2\n",
        "newmtl m\nKd x\n",
        "newmtl m\nmap_Kd\n",
        "newmtl m\nmap_Kd -s\n",
        "newmtl m\nmap_Kd -s 1e9 a.png\n",
        "newmtl m\nmap_Kd -xyz 1 a.png\n",
        "newmtl m\nd\n",
        "newmtl m\nPr 1e400\n",
        "newmtl m\nmap_Kd -o 1 1 1\n -clamp on\n",
    ] {
        let obj = format!("mtllib a.mtl\nusemtl m\n{SQUARE}f 1 2 3\n");
        let error = read_files(&[("m.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]).expect_err(mtl);
        assert!(error.pointer.as_deref().unwrap().starts_with("a.mtl:"), "{mtl}: {error}");
    }
}

#[test]
fn counts_are_limited() {
    let limited = |text: &str, limits: Limits| read_limited(text.as_bytes().to_vec(), limits).unwrap_err();
    let quads = format!("{SQUARE}{}", "f 1 2 3 4\n".repeat(10));
    let error = limited(&quads, Limits { triangles: 19, ..Limits::default() });
    assert_eq!((error.code, error.pointer.as_deref()), (ErrorCode::TooManyTriangles, Some("model:14")));
    let line = format!("{SQUARE}f{}\n", " 1 2 3".repeat(100_000));
    let error = limited(&line, Limits { triangles: 1000, ..Limits::default() });
    assert_eq!(
        (error.code, error.limit, error.actual),
        (ErrorCode::TooManyTriangles, Some(1000), Some(1001))
    );
    let error = limited(&quads, Limits { vertices: 3, ..Limits::default() });
    assert_eq!((error.code, error.pointer.as_deref()), (ErrorCode::ModelTooLarge, Some("model:4")));
}

/// A polygon of 100 000 corners in a comb, and one whose corners all stand in one place.
#[test]
fn huge_polygons_are_cut() {
    let count = 100_000;
    let mut text = String::new();
    for i in 0..count / 2 {
        text += &format!("v {i} {} 0\n", i % 2 * 50);
    }
    for i in (0..count / 2).rev() {
        text += &format!("v {i} {} 0\n", i % 2 * 50 + 1);
    }
    text += "f";
    for i in 1..=count {
        text += &format!(" {i}");
    }
    let asset = read_text(&text).unwrap();
    assert_eq!(first(&asset).faces.len(), count - 2);
    let asset = read_text(&format!("v 0 0 0\nf{}\n", " 1".repeat(count))).unwrap();
    assert_eq!(first(&asset).faces.len(), count - 2);
    assert_eq!(asset.warnings[0].code, "polygon_not_simple");
}
