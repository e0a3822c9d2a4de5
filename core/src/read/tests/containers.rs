//! GLB framing, JSON limits, and what kind of file it is.

use super::*;

fn invalid(bytes: Vec<u8>, words: &str) {
    let error = read_bytes(bytes).expect_err(words);
    assert_eq!(error.code, ErrorCode::InvalidModel, "{error}");
    assert!(error.detail.contains(words), "{error}");
}

#[test]
fn glb_lengths_are_held_against_the_file() {
    let good = Gltf::triangle().glb();
    assert!(read_bytes(good.clone()).is_ok());
    let with = |at: usize, value: u32| {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    let length = good.len() as u32;
    invalid(with(8, length - 4), "header says");
    invalid(with(8, u32::MAX), "header says");
    invalid(with(12, u32::MAX), "chunk 0 says");
    invalid(with(12, u32::MAX - 3), "chunk 0 says");
    invalid(with(12, 2), "multiple of 4");
    invalid(with(4, 1), "version 1");
    let mut longer = good.clone();
    longer.extend([0; 4]);
    invalid(longer, "header says");
    for cut in [5, 11, 12, 15, 19, 20, 40, good.len() - 1] {
        invalid(good[..cut].to_vec(), "");
    }
}

#[test]
fn glb_chunks_come_in_order() {
    let json = Gltf::triangle().json.to_string();
    let json = json.as_bytes();
    invalid(glb(&[]), "no JSON chunk");
    invalid(glb(&[(b"JSON", json), (b"JSON", json)]), "second JSON chunk");
    invalid(glb(&[(b"BIN\0", &[0; 36]), (b"JSON", json)]), "JSON chunk, which must come first");
    invalid(glb(&[(b"JSON", json), (b"BIN\0", &[]), (b"BIN\0", &[])]), "BIN chunk");
    invalid(glb(&[(b"JSON", b"{]")]), "JSON cannot be read");
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"][0]["byteLength"] = json!(36);
    let text = gltf.json.to_string();
    let chunks: &[(&[u8; 4], &[u8])] =
        &[(b"JSON", text.as_bytes()), (b"BIN\0", &gltf.bin), (b"XTRA", b"more")];
    assert!(read_bytes(glb(chunks)).is_ok());
}

#[test]
fn other_files_are_told_by_their_first_bytes() {
    let cases: [&[u8]; 6] =
        [b"", b"glTG\x02\0\0\0", b"\x89PNG\r\n\x1a\n", b"plain words", b"\0\0\0\0", b"solid x\nfacet"];
    for bytes in cases {
        let error = read_bytes(bytes.to_vec()).unwrap_err();
        assert_eq!(error.code, ErrorCode::UnsupportedMediaType, "{bytes:?}: {error}");
    }
}

#[test]
fn json_depth_and_size_are_limited_before_parsing() {
    let deep = |count: usize| format!("{{\"a\":{}1{}}}", "[".repeat(count), "]".repeat(count));
    for text in [deep(200_000), deep(127), format!("{{\"a\":{}", "[".repeat(32 << 20))] {
        let error = read_bytes(text.into_bytes()).unwrap_err();
        assert_eq!(error.code, ErrorCode::ModelTooLarge, "{error}");
    }
    // Brackets in strings are no nesting.
    let text = format!("{{\"asset\":{{\"version\":\"2.0\",\"extras\":\"\\\"{}\"}}}}", "[".repeat(1000));
    assert!(read_bytes(text.into_bytes()).is_ok());
    assert!(
        read_bytes(format!("{{\"asset\":{{\"version\":\"2.0\"}},{}", &deep(126)[1..]).into_bytes()).is_ok()
    );
    let limits = Limits { json_bytes: 1000, ..Limits::default() };
    let wide = format!("{{\"a\":[{}0]}}", "0,".repeat(400));
    assert_eq!(read_limited(wide.into_bytes(), limits.clone()).unwrap_err().code, ErrorCode::ModelTooLarge);
    let long = format!("{{\"a\":\"{}\"}}", "x".repeat(1000));
    assert_eq!(read_limited(long.into_bytes(), limits).unwrap_err().limit, Some(1000));
}

#[test]
fn duplicate_keys_and_a_byte_order_mark_are_read() {
    let text = "\u{feff}{\"asset\":{\"version\":\"1.0\"},\"asset\":{\"version\":\"2.0\"}}";
    assert!(read_bytes(text.as_bytes().to_vec()).is_ok());
}

#[test]
fn versions_and_shapes_are_checked() {
    invalid(b"{}".to_vec(), "asset");
    invalid(b"{\"asset\":{\"version\":\"1.0\"}}".to_vec(), "version");
    invalid(b"{\"asset\":{\"version\":\"2.1\",\"minVersion\":\"2.1\"}}".to_vec(), "2.1");
    invalid(b"{\"asset\":{\"version\":\"2.0\"},\"nodes\":{}}".to_vec(), "array");
    invalid(b"{\"asset\":{\"version\":\"2.0\"},\"meshes\":[3]}".to_vec(), "object");
}

#[test]
fn required_extensions_are_refused_by_name() {
    let mut gltf = Gltf::triangle();
    gltf.json["extensionsRequired"] = json!([
        "KHR_texture_transform",
        "KHR_lights_punctual",
        "KHR_materials_unlit",
        "MCT_mesh_color_texture"
    ]);
    assert!(gltf.read().is_ok());
    gltf.push("extensionsRequired", json!("VENDOR_unknown"));
    let error = gltf.refused(ErrorCode::UnsupportedExtension, "/extensionsRequired/4");
    assert!(error.detail.contains("VENDOR_unknown"), "{error}");
}

#[test]
fn canceling_ends_reading() {
    struct Canceled;
    impl crate::watch::Watch for Canceled {
        fn canceled(&self) -> bool {
            true
        }
    }
    let upload = Upload::single("m.glb", Gltf::triangle().glb());
    let error = read(&upload, &Limits::default(), &Canceled).unwrap_err();
    assert_eq!(error.code, ErrorCode::Canceled);
}
