//! Small valid files, bent at random places by a fixed seed: whatever comes out, it is no panic.

use super::ply::Encoding;
use super::*;

/// xorshift64*: enough for choosing places.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize % limit
    }
}

const ROUNDS: usize = 1500;

fn seeds() -> Vec<Vec<u8>> {
    let mut gltf = Gltf::textured(&png(4, 4));
    let normals = gltf.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let indices = gltf.accessor("SCALAR", 5121, 3, &[0, 1, 2]);
    gltf.primitive()["attributes"]["NORMAL"] = json!(normals);
    gltf.primitive()["indices"] = json!(indices);
    gltf.json["nodes"] = json!([{ "children": [1, 2] }, { "mesh": 0 }, { "mesh": 0, "scale": [1, 2, 3] }]);
    let mut text = gltf.json.clone();
    let hex: String = gltf.bin.iter().map(|byte| format!("%{byte:02x}")).collect();
    text["buffers"][0] = json!({ "byteLength": gltf.bin.len(), "uri": format!("data:,{hex}") });
    let obj = b"o a\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0.5 0.5 0 0 0 1\nv 0 1 0 1 1 1\nvt 0 0\n\
        vt 1 0\nvn 0 0 1\nf 1/1/1 2/2/1 3/1/1\nf -5 -4 -3 -2 -1\nf 1//1 2//1 3//1 5//1\nusemtl m\nf 3 2 1\n";
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    zip.start_file("m.obj", zip::write::SimpleFileOptions::default()).unwrap();
    std::io::Write::write_all(&mut zip, obj).unwrap();
    let [etc1s, uastc] = basis::seeds();
    vec![
        gltf.glb(),
        text.to_string().into_bytes(),
        obj.to_vec(),
        zip.finish().unwrap().into_inner(),
        compressed::seed(),
        webp::seed(),
        ply::seed(Encoding::Ascii),
        ply::seed(Encoding::Little),
        ply::seed(Encoding::Big),
        ngons::seed(),
        draco::seed(),
        etc1s,
        uastc,
    ]
}

fn bend(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(4) {
        if bytes.is_empty() {
            return;
        }
        let at = random.below(bytes.len());
        match random.below(6) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = random.below(256) as u8,
            2 => bytes.truncate(at),
            3 => {
                // Digits are where JSON and OBJ hurt.
                let digits = b"0123456789-.eE\"[]{},/ \n";
                bytes[at] = digits[random.below(digits.len())];
            }
            4 => {
                let end = (at + random.below(16)).min(bytes.len());
                bytes.drain(at..end);
            }
            _ => {
                let end = (at + random.below(16)).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
        }
    }
}

/// What `Asset` promises, of an asset that was read.
fn check_guarantees(asset: &Asset) {
    for instance in &asset.instances {
        assert!(instance.mesh < asset.meshes.len() && instance.transform.is_finite());
    }
    for slot in asset.materials.iter().flat_map(|material| material.slots.values()) {
        assert!(slot.image < asset.images.len());
    }
    assert_eq!(asset.images.len(), asset.document.encoded_images.len());
    for primitive in asset.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let count = primitive.positions.len();
        assert!(primitive.material.is_none_or(|material| material < asset.materials.len()));
        assert!(primitive.faces.iter().all(|face| matches!(face.count, 3 | 4)));
        assert!(primitive.faces.iter().flat_map(|face| face.corners).all(|corner| (corner as usize) < count));
        assert!(primitive.positions.iter().all(|position| position.is_finite()));
        assert!(
            [0, count].contains(&primitive.normals.len()) && [0, count].contains(&primitive.tangents.len())
        );
        assert!(primitive.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5));
        for set in &primitive.texcoords {
            assert!(set.len() == count && set.iter().all(|uv| uv.abs().max_element() <= 1e6));
        }
        for attribute in &primitive.attributes {
            assert_eq!(attribute.bytes.len(), attribute.element_bytes * count);
        }
    }
}

#[test]
fn bent_files_end_in_an_asset_or_an_error() {
    for (number, seed) in seeds().into_iter().enumerate() {
        // An OBJ that asks for a material has no library here, which is allowed.
        check_guarantees(&read_bytes(seed.clone()).unwrap());
        let mut random = Random(0x9E37_79B9_7F4A_7C15 + number as u64);
        let mut read_count = 0;
        for _ in 0..ROUNDS {
            let mut bytes = seed.clone();
            bend(&mut bytes, &mut random);
            let limits =
                Limits { vertices: 10_000, triangles: 10_000, job_pixels: 1 << 16, ..Limits::default() };
            match read_limited(bytes, limits) {
                Ok(asset) => {
                    read_count += 1;
                    check_guarantees(&asset);
                }
                Err(error) => assert_ne!(error.code, ErrorCode::Internal, "{error}"),
            }
        }
        // Neither does everything fail at the first byte, nor does nothing.
        assert!((1..ROUNDS).contains(&read_count), "seed {number}: {read_count} of {ROUNDS} were read");
    }
}

#[test]
fn every_truncation_ends_in_an_asset_or_an_error() {
    for seed in seeds() {
        for length in 0..seed.len() {
            if let Ok(asset) = read_bytes(seed[..length].to_vec()) {
                check_guarantees(&asset);
            }
        }
    }
}
