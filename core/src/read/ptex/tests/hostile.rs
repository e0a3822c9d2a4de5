//! Headers that lie: an error with words, before memory is taken.

use super::*;

fn quad(log2: [u8; 2], stored: Stored) -> Ptex {
    let numbers = (0..3usize << (log2[0] + log2[1])).map(|k| (k * 37 % 256) as f32).collect();
    let face = Face { log2, neighbours: [None; 4], is_subface: false, stored, numbers };
    Ptex { is_triangles: false, data: writer::U8, channels: 3, alpha: None, faces: vec![face] }
}

fn refused(bytes: &[u8]) -> Error {
    read_as(bytes, &[vec![0, 1, 2, 3]], Kind::Color, &Limits::default()).expect_err("must be refused")
}

fn with_word(bytes: &[u8], at: usize, word: u32) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
    bytes
}

#[test]
fn header_fields_are_checked() {
    let bytes = quad([2, 2], Stored::Zipped).bytes();
    let cases = [
        (4, 2, "version 2"),
        (8, 2, "mesh type 2"),
        (12, 4, "data type 4"),
        (16, 3, "alpha channel is number 3 of 3"),
        (20, 0x0001_0000, "0 channels"),
        (20, 0x0001_FFFF, "65535 channels"),
        (24, 2, "level 0 lists 1 faces"),
        (28, u32::MAX, "extended header takes 4294967295 bytes"),
        (32, u32::MAX, "face info takes"),
        (36, u32::MAX, "constant data takes"),
        (40, u32::MAX, "level info takes"),
        (40, 15, "no level 0"),
        (48, u32::MAX, "level data takes"),
        (52, u32::MAX, "level data takes"),
    ];
    for (at, word, words) in cases {
        let error = refused(&with_word(&bytes, at, word));
        assert_eq!(error.code, ErrorCode::InvalidModel, "{error}");
        assert!(error.detail.contains(words), "{at}: {error}");
    }
    assert!(refused(b"PtexX").detail.contains("header"), "{}", refused(b"PtexX"));
}

/// The file says how large its blocks are unpacked, and deflate bounds what they can be.
#[test]
fn counts_beyond_the_file_take_no_memory() {
    let bytes = quad([2, 2], Stored::Zipped).bytes();
    // Four thousand million faces, in the header and in level 0.
    let levels = 64
        + [28, 32, 36]
            .map(|at| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()))
            .iter()
            .sum::<u32>();
    let mut many = with_word(&bytes, 24, u32::MAX);
    many = with_word(&many, levels as usize + 12, u32::MAX);
    let listed = |bytes: &[u8]| faces::read(&header::split(bytes).unwrap(), &Limits::default()).unwrap_err();
    let error = listed(&many);
    assert_eq!((error.code, error.limit), (ErrorCode::ModelTooLarge, Some(1 << 30)), "{error}");
    let mut some = with_word(&bytes, 24, 1 << 20);
    some = with_word(&some, levels as usize + 12, 1 << 20);
    assert!(listed(&some).detail.contains("does not unpack to 20971520 bytes"), "{}", listed(&some));
}

#[test]
fn faces_too_large_for_their_data_are_refused() {
    // As large as a face may be, with the data of a small one.
    let large = Ptex {
        faces: vec![Face { log2: [12, 12], ..quad([1, 1], Stored::Constant).faces[0].clone() }],
        ..quad([0, 0], Stored::Zipped)
    };
    let error = refused(&large.bytes());
    assert_eq!((error.code, error.limit), (ErrorCode::ImageTooLarge, Some(67_108_864)), "{error}");
    assert!(error.detail.contains("8193"), "{error}");
    let mut zipped = quad([1, 1], Stored::Zipped);
    let (bytes, limits) = (zipped.bytes(), Limits::default());
    let info = writer::zipped(&[vec![10, 10], vec![0; 2], vec![0xFF; 16]].concat());
    let old = u32::from_le_bytes(bytes[32..36].try_into().unwrap()) as usize;
    let mut bent = with_word(&bytes, 32, info.len() as u32);
    bent.splice(104..104 + old, info);
    let error = read_as(&bent, &[vec![0, 1, 2, 3]], Kind::Color, &limits).unwrap_err();
    assert!(error.detail.contains("face 0: the data does not unpack to 3145728 bytes"), "{error}");
    zipped.faces[0].log2 = [13, 0];
    zipped.faces[0].stored = Stored::Flagged;
    assert!(refused(&zipped.bytes()).detail.contains("2^13 x 2^0 texels"), "{}", refused(&zipped.bytes()));
}

#[test]
fn limits_are_named() {
    let bytes = quad([5, 5], Stored::Zipped).bytes();
    let read = |limits: Limits| read_as(&bytes, &[vec![0, 1, 2, 3]], Kind::Color, &limits).unwrap_err();
    for (limits, name) in [
        (Limits { image_side: 64, ..Limits::default() }, "image_side"),
        (Limits { image_pixels: 65 * 65, ..Limits::default() }, "image_pixels"),
        (Limits { job_pixels: 65 * 65, ..Limits::default() }, "job_pixels"),
        (Limits { archive_bytes: 3000, ..Limits::default() }, "archive_bytes"),
    ] {
        let error = read(limits);
        assert!(error.detail.contains(name), "{name}: {error}");
        assert!(error.limit.is_some() && error.actual > error.limit, "{error}");
    }
}

#[test]
fn triangles_must_be_square() {
    let mut file = quad([2, 1], Stored::Zipped);
    file.is_triangles = true;
    let error = read_as(&file.bytes(), &[vec![0, 1, 2]], Kind::Color, &Limits::default()).unwrap_err();
    assert!(error.detail.contains("must be square"), "{error}");
}

fn seeds() -> Vec<(Vec<u8>, Vec<Vec<u32>>)> {
    let mut random = Random(8);
    let quads = vec![vec![0, 1, 2, 3], vec![1, 4, 5, 2], vec![2, 5, 6, 7]];
    let triangles = vec![vec![0, 1, 2], vec![2, 1, 3]];
    let mut seeds = Vec::new();
    for (faces, data) in [(quads, writer::U8), (triangles, writer::HALF)] {
        let mut model = Model::random(faces, data, &mut random, |_| [2, 2]);
        let ways = [Stored::Tiled([1, 1]), Stored::DiffZipped, Stored::Flagged];
        for (face, stored) in model.file.faces.iter_mut().zip(ways) {
            face.stored = stored;
        }
        seeds.push((model.file.bytes(), model.faces));
    }
    seeds
}

fn try_one(bytes: &[u8], faces: &[Vec<u32>]) -> bool {
    // The mesh is another one's matter: it has as many faces as the header says, or nothing is read.
    let limits = Limits { job_pixels: 1 << 16, ..Limits::default() };
    let Ok(head) = head(bytes) else { return false };
    if head != (Head { face_count: faces.len(), corner_count: faces[0].len() }) {
        return false;
    }
    match read_as(bytes, faces, Kind::Color, &limits) {
        Ok((painted, _)) => {
            let Pixels::F32(of) = &painted.image.pixels else { panic!("values") };
            assert!(of.values.iter().all(|value| value.is_finite()));
            assert_eq!(of.values.len(), painted.image.texel_count() * usize::from(painted.image.components));
            assert_eq!(painted.texcoords.len(), faces.concat().len());
            true
        }
        Err(error) => {
            assert_ne!(error.code, ErrorCode::Internal, "{error}");
            false
        }
    }
}

#[test]
fn every_truncation_is_an_error_or_a_texture() {
    for (bytes, faces) in seeds() {
        assert!(try_one(&bytes, &faces));
        for length in 0..bytes.len() {
            try_one(&bytes[..length], &faces);
        }
    }
}

#[test]
fn bent_files_are_an_error_or_a_texture() {
    for (number, (seed, faces)) in seeds().into_iter().enumerate() {
        let mut random = Random(0xABCD_EF01 + number as u64);
        let mut read_count = 0;
        const ROUNDS: usize = 4000;
        for _ in 0..ROUNDS {
            let mut bytes = seed.clone();
            for _ in 0..=random.below(3) {
                let at = random.below(bytes.len());
                match random.below(4) {
                    0 => bytes[at] ^= 1 << random.below(8),
                    1 => bytes[at] = random.below(256) as u8,
                    2 => drop(bytes.remove(at)),
                    _ => bytes.insert(at, random.below(256) as u8),
                }
            }
            read_count += usize::from(try_one(&bytes, &faces));
        }
        assert!((1..ROUNDS).contains(&read_count), "seed {number}: {read_count} of {ROUNDS} were read");
    }
}
