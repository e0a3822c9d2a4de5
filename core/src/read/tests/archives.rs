//! Zip uploads (B8 of the abuse list).

use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::*;

fn options() -> SimpleFileOptions {
    SimpleFileOptions::default().compression_method(CompressionMethod::Deflated)
}

fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        writer.start_file(*name, options()).unwrap();
        writer.write_all(bytes).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

fn refused(bytes: Vec<u8>, code: ErrorCode, words: &str) {
    let error = read_bytes(bytes).expect_err(words);
    assert_eq!(error.code, code, "{error}");
    assert!(error.to_string().contains(words), "{error}");
}

#[test]
fn a_model_is_read_with_the_files_of_its_folder() {
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"][0] = json!({ "byteLength": gltf.bin.len(), "uri": "sub/b.bin" });
    let text = gltf.json.to_string();
    let files: &[(&str, &[u8])] = &[
        ("readme.txt", b"hello"),
        ("deep/m.GLTF", text.as_bytes()),
        ("deep/sub/b.bin", &gltf.bin),
        ("__MACOSX/deep/._m.gltf", b"resource fork"),
    ];
    assert_eq!(read_bytes(archive(files)).unwrap().document.buffers, [gltf.bin.clone()]);
    assert!(read_bytes(archive(&[("m.glb", &gltf.glb())])).is_err(), "the buffer is elsewhere");
}

#[test]
fn exactly_one_model() {
    let glb = Gltf::triangle().glb();
    refused(
        archive(&[("a.glb", &glb), ("b/c.OBJ", b"v")]),
        ErrorCode::InvalidModel,
        "\"a.glb\", \"b/c.OBJ\"",
    );
    refused(archive(&[("a.txt", b"x")]), ErrorCode::InvalidModel, "no model");
    refused(archive(&[]), ErrorCode::InvalidModel, "no model");
    refused(
        archive(&[("a.glb", &archive(&[("a.glb", &glb)]))]),
        ErrorCode::InvalidModel,
        "itself an archive",
    );
}

#[test]
fn names_that_leave_the_archive_are_refused() {
    for name in ["../m.glb", "/m.glb", "a/../../m.glb", "a\\m.glb", "C:/m.glb"] {
        // The writer would mend the name; so a harmless one of the same length is replaced in the bytes.
        let harmless = "x".repeat(name.len());
        let mut bytes = archive(&[(&harmless, b"x")]);
        while let Some(at) = bytes.windows(name.len()).position(|part| part == harmless.as_bytes()) {
            bytes[at..at + name.len()].copy_from_slice(name.as_bytes());
        }
        refused(bytes, ErrorCode::UnsafeUri, "");
    }
}

#[test]
fn links_duplicates_and_encryption_are_refused() {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    writer.add_symlink("m.glb", "/etc/passwd", options()).unwrap();
    refused(writer.finish().unwrap().into_inner(), ErrorCode::UnsafeUri, "symbolic link");

    let mut bytes = archive(&[("a.obj", b"v 1 2 3"), ("b.obj", b"v 1 2 3")]);
    while let Some(at) = bytes.windows(5).position(|part| part == b"b.obj") {
        bytes[at] = b'a';
    }
    refused(bytes, ErrorCode::InvalidModel, "two entries of one name");

    let mut bytes = archive(&[("a.obj", b"v 1 2 3")]);
    for (signature, flags) in [(b"PK\x03\x04", 6), (b"PK\x01\x02", 8)] {
        let at = bytes.windows(4).position(|part| part == signature).unwrap();
        bytes[at + flags] |= 1;
    }
    refused(bytes, ErrorCode::InvalidModel, "encrypted");
}

#[test]
fn unpacking_stops_at_the_limits() {
    let bomb = archive(&[("a.obj", &vec![0; 8 << 20])]);
    refused(bomb, ErrorCode::ArchiveRatio, "archive_ratio");
    let text = format!("v 1 2 3{}", " ".repeat(900_000));
    let small = archive(&[("a.obj", text.as_bytes())]);
    // Less than a MiB, whatever the ratio: what fails is the model.
    refused(small.clone(), ErrorCode::NothingToConvert, "no faces");
    let limits = Limits { archive_bytes: 800_000, ..Limits::default() };
    assert_eq!(read_limited(small, limits).unwrap_err().code, ErrorCode::ArchiveTooLarge);
    let names: Vec<String> = (0..1001).map(|number| format!("{number}")).collect();
    let files: Vec<(&str, &[u8])> = names.iter().map(|name| (name.as_str(), &b""[..])).collect();
    refused(archive(&files), ErrorCode::TooManyFiles, "archive_entries");
}

#[test]
fn declared_sizes_are_not_believed() {
    let glb = Gltf::triangle().glb();
    let good = archive(&[("a.glb", &glb)]);
    assert!(read_bytes(good.clone()).is_ok());
    // Uncompressed sizes in both headers, to 4 GB and to nothing.
    for size in [u32::MAX - 1, 0] {
        let mut bytes = good.clone();
        for (signature, offset) in [(b"PK\x03\x04", 22), (b"PK\x01\x02", 24)] {
            let at = bytes.windows(4).position(|part| part == signature).unwrap() + offset;
            bytes[at..at + 4].copy_from_slice(&size.to_le_bytes());
        }
        // Whether it is read or refused is the unpacker's choice; it must not trust the figure.
        if let Ok(asset) = read_bytes(bytes) {
            assert_eq!(asset.meshes.len(), 1);
        }
    }
    for cut in [4, 30, good.len() / 2, good.len() - 1] {
        assert!(read_bytes(good[..cut].to_vec()).is_err(), "{cut}");
    }
}
