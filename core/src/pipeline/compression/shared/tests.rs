use std::collections::BTreeSet;

use super::*;
use crate::asset::Slot;
use crate::image::Transfer;
use crate::layout::Coordinates;
use crate::pipeline::Options;
use crate::pipeline::tests::{finish, noise_asset};

const BOTH: [Coordinates; 2] = [Coordinates::Scaled, Coordinates::Indexed];

fn finished(seed: u64, coordinates: Coordinates) -> (Asset, Finished) {
    let asset = noise_asset(seed, 6, Slot::MetallicRoughness);
    let options = Options { cut_codes: 255.0, coordinates, ..Options::default() };
    let (finished, _) = finish(&asset, &options);
    (asset, finished)
}

/// Groups by level.
fn all_groups(asset: &Asset, finished: &Finished) -> Vec<Vec<Vec<u32>>> {
    let edges = Edges::of(asset, finished, 0);
    let levels = finished.textures[0].levels.iter().enumerate();
    levels.map(|(number, image)| edges.groups(number, image.size())).collect()
}

#[test]
fn texels_of_one_group_hold_one_value() {
    for coordinates in BOTH {
        let (asset, finished) = finished(5, coordinates);
        let all = all_groups(&asset, &finished);
        for (number, groups) in all.iter().enumerate() {
            let image = &finished.textures[0].levels[number];
            let value =
                |texel: &u32| image.linear(texel % image.width, texel / image.width, Transfer::Linear);
            for group in groups {
                let first = value(&group[0]);
                assert!(
                    group.iter().all(|texel| value(texel) == first),
                    "{coordinates:?}, level {number}: {group:?}"
                );
            }
        }
        assert!(all[0].len() > 100, "{coordinates:?}: {}", all[0].len());
    }
}

#[test]
fn only_indexed_coordinates_share_texels_beyond_vertex_colors() {
    let last = |coordinates| {
        let (asset, finished) = finished(5, coordinates);
        all_groups(&asset, &finished).pop().unwrap()
    };
    assert!(last(Coordinates::Scaled).is_empty());
    assert!(!last(Coordinates::Indexed).is_empty());
}

/// Corners at one position hold one sample. All but those of faces that touch nowhere else are joined by edges.
#[test]
fn corners_of_a_vertex_are_one_group_at_every_level() {
    let (asset, finished) = finished(7, Coordinates::Indexed);
    let piece = &finished.primitives[0];
    let positions = &asset.meshes[0].primitives[0].positions;
    for (number, groups) in all_groups(&asset, &finished).iter().enumerate() {
        let size = finished.textures[0].levels[number].size();
        let mut corners: BTreeMap<[u32; 3], BTreeSet<u32>> = BTreeMap::new();
        for (triangle, vertices) in piece.triangles.iter().map(|triangle| triangle.vertices).enumerate() {
            for corner in 0..3 {
                let at = positions[vertices[corner] as usize].to_array().map(f32::to_bits);
                corners
                    .entry(at)
                    .or_default()
                    .insert(texel(piece.place(triangle, corner, number), size).unwrap());
            }
        }
        let is_group = |texels: &&BTreeSet<u32>| {
            groups.iter().any(|group| texels.iter().all(|texel| group.contains(texel)))
        };
        let shared = corners.values().filter(|texels| texels.len() > 1);
        let (known, unknown): (Vec<_>, Vec<_>) = shared.partition(is_group);
        assert!(unknown.len() * 10 <= known.len(), "level {number}: {unknown:?}");
    }
}
