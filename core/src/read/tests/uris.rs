//! Where URIs may point (B1 to B3 of the abuse list), in every place that a model can name a file.

use super::*;

const UNSAFE: &[&str] = &[
    "file:///etc/passwd",
    "/etc/passwd",
    "../s.bin",
    "a/../../s.bin",
    "%2e%2e/s.bin",
    "..%2f",
    "%252e%252e/s.bin",
    "..\\s.bin",
    "\\\\host\\x",
    "C:/x",
    "c:x",
    "//host/x",
    "%2Fetc/passwd",
    "javascript:x",
];

const EXTERNAL: &[&str] = &[
    "http://169.254.169.254/",
    "https://canary/x",
    "HTTP://canary/x",
    "ftp://canary/x",
    "gopher://canary/x",
    "http%3A//canary/x",
    "s3://bucket/x",
];

fn with_buffer(uri: &str) -> Result<Asset> {
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"][0] = json!({ "byteLength": 36, "uri": uri });
    read_bytes(gltf.json.to_string().into_bytes())
}

fn with_image(uri: &str) -> Result<Asset> {
    let mut gltf = Gltf::textured(&png(1, 1));
    gltf.json["images"][0] = json!({ "uri": uri });
    gltf.read()
}

fn with_library(name: &str) -> Result<Asset> {
    read_bytes(format!("mtllib {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").into_bytes())
}

fn with_map(name: &str) -> Result<Asset> {
    let mtl = format!("newmtl m\nmap_Kd -s 1 1 1 {name}\n");
    read_files(&[
        ("a.obj", b"mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("a.mtl", mtl.as_bytes()),
    ])
}

/// Reads a model that names a file in one place.
type Place = fn(&str) -> Result<Asset>;

#[test]
fn unsafe_and_external_uris_are_refused_everywhere() {
    let places: [(Place, &str); 4] = [
        (with_buffer, "/buffers/0/uri"),
        (with_image, "/images/0/uri"),
        (with_library, "model:1"),
        (with_map, "a.mtl:2"),
    ];
    for (place, pointer) in places {
        for (uris, code) in [(UNSAFE, ErrorCode::UnsafeUri), (EXTERNAL, ErrorCode::ExternalUri)] {
            for uri in uris {
                let error = place(uri).expect_err(uri);
                assert_eq!((error.code, error.pointer.as_deref()), (code, Some(pointer)), "{uri}: {error}");
            }
        }
    }
}

#[test]
fn nul_and_invalid_utf8_are_refused() {
    for uri in ["a%00.bin", "%ff%fe.bin"] {
        assert_eq!(with_buffer(uri).unwrap_err().code, ErrorCode::UnsafeUri, "{uri}");
    }
    let mut obj = b"mtllib ".to_vec();
    obj.extend(b"\xff\xfe.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(read_bytes(obj).unwrap_err().code, ErrorCode::UnsafeUri);
}

#[test]
fn ordinary_names_are_found() {
    let gltf = Gltf::triangle();
    let cases = [
        ("A..B.bin", "A..B.bin"),
        ("with space.bin", "with space.bin"),
        ("with%20space.bin", "with space.bin"),
        ("%C3%A4.bin", "ä.bin"),
        ("ä.bin", "ä.bin"),
        ("./sub//b.bin", "sub/b.bin"),
        ("100%.bin", "100%.bin"),
    ];
    for (uri, name) in cases {
        let mut json = gltf.json.clone();
        json["buffers"][0] = json!({ "byteLength": 36, "uri": uri });
        let text = json.to_string();
        let stored = format!("folder/{name}");
        let asset = read_files(&[("folder/m.gltf", text.as_bytes()), (&stored, &gltf.bin)]);
        assert_eq!(asset.expect(uri).document.buffers[0], gltf.bin, "{uri}");
    }
}

#[test]
fn names_are_case_exact_and_missing_ones_are_listed() {
    let mut json = Gltf::triangle().json;
    json["buffers"][0] = json!({ "byteLength": 36, "uri": "A.bin" });
    let text = json.to_string();
    let error = read_files(&[("m.gltf", text.as_bytes()), ("a.bin", &[0; 36])]).unwrap_err();
    assert_eq!(error.code, ErrorCode::MissingResource);
    assert!(error.detail.contains("\"A.bin\"") && error.detail.contains("\"a.bin\""), "{error}");
}

#[test]
fn data_uris_are_bytes() {
    let zeros = format!("data:application/octet-stream;base64,{}", "A".repeat(48));
    let cases = [
        zeros.as_str(),
        &format!("DATA:,{}", "%00".repeat(36)),
        &format!("data:;base64,{}==", "A".repeat(50)),
    ];
    for uri in cases {
        assert_eq!(with_buffer(uri).expect(uri).document.buffers[0], [0; 36], "{uri}");
    }
    for uri in ["data:;base64", "data:;base64,A", "data:;base64,AA=A", "data:;base64,A*AA"] {
        assert_eq!(with_buffer(uri).expect_err(uri).code, ErrorCode::InvalidModel, "{uri}");
    }
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"][0] = json!({ "byteLength": 3, "uri": "data:;base64,aGk/" });
    gltf.json["accessors"] = json!([]);
    gltf.json["bufferViews"] = json!([]);
    gltf.json["meshes"] = json!([]);
    gltf.json["nodes"] = json!([{}]);
    let asset = read_bytes(gltf.json.to_string().into_bytes()).unwrap();
    assert_eq!(asset.document.buffers[0], b"hi?");
}

#[test]
fn resolved_bytes_are_limited_together() {
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"] = json!(vec![json!({ "byteLength": 36, "uri": "b.bin" }); 40]);
    let text = gltf.json.to_string();
    let files = BTreeMap::from([("m".to_owned(), text.into_bytes()), ("b.bin".to_owned(), vec![0; 1000])]);
    let upload = Upload { main: "m".to_owned(), files: Box::new(MemoryFiles(files)) };
    let limits = Limits { archive_bytes: 30_000, ..Limits::default() };
    let error = read(&upload, &limits, &Unwatched).unwrap_err();
    assert_eq!((error.code, error.pointer.as_deref()), (ErrorCode::ModelTooLarge, Some("/buffers/30/uri")));
}
