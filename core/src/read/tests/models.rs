//! Real models from the model folder.

use crate::asset::{AlphaMode, Asset, Slot};
use crate::error::Result;
use crate::read::{Limits, MemoryFiles, Upload, read};
use crate::watch::Unwatched;
use glam::{Vec2, Vec3};
use std::path::PathBuf;

fn folder() -> PathBuf {
    match std::env::var_os("MESHCOLOR_ASSETS") {
        Some(folder) => PathBuf::from(folder),
        None => PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/assets"),
    }
}

/// A model with the files beside it; `None` (said aloud) without the model folder.
fn model(name: &str) -> Option<Result<Asset>> {
    let path = folder().join(name);
    let (Some(parent), true) = (path.parent(), path.exists()) else {
        println!("skipped: {name} (no model folder)");
        return None;
    };
    let mut files = MemoryFiles::default();
    for entry in std::fs::read_dir(parent).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            files.0.insert(name, std::fs::read(&path).unwrap());
        }
    }
    let main = path.file_name().unwrap().to_string_lossy().into_owned();
    Some(read(&Upload { main, files: Box::new(files) }, &Limits::default(), &Unwatched))
}

fn face_counts(asset: &Asset) -> [usize; 2] {
    let faces = || asset.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| &p.faces);
    [faces().filter(|f| f.count == 3).count(), faces().filter(|f| f.count == 4).count()]
}

#[test]
fn damaged_helmet() {
    let Some(asset) = model("DamagedHelmet.glb") else { return };
    let asset = asset.unwrap();
    assert_eq!(face_counts(&asset), [15452, 0]);
    assert_eq!(asset.images.len(), 5);
    assert!(asset.images.iter().all(|image| image.size() == [2048, 2048]));
    assert!(asset.materials[0].slots.keys().eq(&Slot::CORE));
    assert_eq!(asset.instances.len(), 1);
}

#[test]
fn fox() {
    let Some(asset) = model("Fox.glb") else { return };
    let asset = asset.unwrap();
    assert_eq!(face_counts(&asset), [576, 0]);
    let names: Vec<&str> =
        asset.meshes[0].primitives[0].attributes.iter().map(|a| a.semantic.as_str()).collect();
    assert_eq!(names, ["JOINTS_0", "WEIGHTS_0"]);
}

/// Packed by gltfpack, positions of 16 bits, octahedral normals.
#[test]
fn pirate_is_unpacked() {
    let Some(asset) = model("pirate.glb") else { return };
    let asset = asset.unwrap();
    assert_eq!(face_counts(&asset), [5010, 0]);
    let primitive = &asset.meshes[0].primitives[0];
    assert_eq!((primitive.positions.len(), primitive.normals.len()), (2887, 2887));
    // The bounds that the file gives of its positions.
    let least = primitive.positions.iter().copied().reduce(Vec3::min).unwrap();
    let most = primitive.positions.iter().copied().reduce(Vec3::max).unwrap();
    assert_eq!([least, most], [Vec3::ZERO, Vec3::new(13081.0, 16383.0, 3915.0)]);
    assert!(asset.images.is_empty());
    assert_eq!(asset.warnings, []);
}

#[test]
fn objs_of_spot() {
    // Faces by corners: the control mesh has 4 triangles, 160 quads and 16 pentagons.
    let cases = [
        ("spot/spot_fine.obj", [5856, 0]),
        ("spot/spot_tri.obj", [372, 0]),
        ("spot/spot_control_mesh.obj", [4 + 3 * 16, 160]),
    ];
    for (name, counts) in cases {
        let Some(asset) = model(name) else { return };
        let asset = asset.unwrap();
        assert_eq!(face_counts(&asset), counts, "{name}");
        assert_eq!(asset.warnings, [], "{name}");
        assert_eq!(asset.images[0].size(), [1024, 1024], "{name}");
        let material = &asset.materials[0];
        assert_eq!(material.slot(Slot::BaseColor).map(|slot| slot.image), Some(0), "{name}");
        assert_eq!(material.base_color_factor, glam::Vec4::ONE, "{name}");
        assert_eq!(material.alpha_mode, AlphaMode::Opaque, "{name}");
        assert_eq!(asset.meshes.len(), asset.document.json["nodes"].as_array().unwrap().len());
    }
}

#[test]
fn quads_without_a_library() {
    let Some(asset) = model("monsterfrog.obj") else { return };
    let asset = asset.unwrap();
    assert_eq!(face_counts(&asset), [0, 1292]);
    assert_eq!(asset.meshes[0].name, "monsterfrog");
}

#[test]
fn degenerate_models_are_read_and_reported() {
    let cases = [
        ("cube", 12, None),
        ("degenerate_edge", 2, Some("degenerate_face")),
        ("double_sided", 4, None),
        ("duplicate_edge", 2, None),
        ("gazebo", 730, None),
        ("zero_area_face", 1, Some("zero_area_face")),
        ("zero_length_edge", 2, Some("zero_area_face")),
    ];
    for (name, faces, warning) in cases {
        let Some(asset) = model(&format!("degenerate/{name}.obj")) else { return };
        let asset = asset.unwrap();
        assert_eq!(face_counts(&asset), [faces, 0], "{name}");
        let codes: Vec<&str> = asset.warnings.iter().map(|warning| warning.code.as_str()).collect();
        assert_eq!(codes, Vec::from_iter(warning), "{name}: {:?}", asset.warnings);
    }
}

/// The gltf crate as a foreign judge: the same positions, indices and coordinates from valid files.
#[test]
fn valid_files_read_as_the_gltf_crate_reads_them() {
    for name in ["Fox.glb", "DamagedHelmet.glb"] {
        let Some(asset) = model(name) else { return };
        let asset = asset.unwrap();
        let bytes = std::fs::read(folder().join(name)).unwrap();
        let foreign = ::gltf::Gltf::from_slice(&bytes).unwrap();
        let blob = foreign.blob.clone().unwrap();
        let theirs = foreign.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>());
        let ours = asset.meshes.iter().flat_map(|mesh| &mesh.primitives);
        for (ours, theirs) in ours.zip(theirs) {
            let reader = theirs.reader(|_| Some(&blob));
            let positions: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
            assert_eq!(ours.positions, positions, "{name}");
            let coordinates = reader.read_tex_coords(0).unwrap().into_f32();
            assert_eq!(ours.texcoords[0], coordinates.map(Vec2::from).collect::<Vec<_>>(), "{name}");
            let indices: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..positions.len() as u32).collect(),
            };
            let corners: Vec<u32> = ours.faces.iter().flat_map(|face| face.corners().to_vec()).collect();
            assert_eq!(corners, indices, "{name}");
        }
    }
}
