//! Faces that store the same texels as another face, in every channel at every level.

use rayon::prelude::*;

use crate::image::{Image, Pixels};
use crate::math::random::scatter;

use super::Painted;
use super::texels::{FaceTexels, are_equal};
use super::turn::Turn;

/// A face is compared with so many others of the same sum at most.
const COMPARED_MAX: usize = 64;

/// A face that another one stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Twin {
    pub of: u32,
    /// Lays the face on the other.
    pub turn: Turn,
}

/// By face: the first one that stores the same.
pub fn twins(painted: &Painted<'_>) -> Vec<Option<Twin>> {
    let face_count = painted.layout.placements.len();
    let mut twins = vec![None; face_count];
    let key = |face: usize| {
        let block = painted.layout.block(face);
        (block.kind.is_lone(), block.exponents, sum(painted, face))
    };
    let mut keys: Vec<_> = (0..face_count).into_par_iter().map(|face| (key(face), face as u32)).collect();
    keys.sort_unstable();
    let groups: Vec<_> = keys.chunk_by(|(a, _), (b, _)| a == b).filter(|group| group.len() > 1).collect();
    let found: Vec<Vec<(u32, Twin)>> = groups.into_par_iter().map(|group| in_group(painted, group)).collect();
    for (face, twin) in found.into_iter().flatten() {
        twins[face as usize] = Some(twin);
    }
    twins
}

/// Among faces with equal sums, in face order.
fn in_group<K>(painted: &Painted<'_>, group: &[(K, u32)]) -> Vec<(u32, Twin)> {
    let mut firsts: Vec<u32> = Vec::new();
    let mut found = Vec::new();
    for &(_, face) in group {
        let twin =
            firsts.iter().find_map(|&of| turn_between(painted, face, of).map(|turn| Twin { of, turn }));
        match twin {
            Some(twin) => found.push((face, twin)),
            None if firsts.len() < COMPARED_MAX => firsts.push(face),
            None => {}
        }
    }
    found
}

/// What lays one face on another so that all texels agree.
fn turn_between(painted: &Painted<'_>, face: u32, of: u32) -> Option<Turn> {
    let block = painted.layout.block(face as usize);
    let fits = |turn: &Turn| {
        if block.kind.is_lone() {
            turn.is_flipped == [false; 2]
        } else {
            turn.pair(block.exponents) == block.exponents
        }
    };
    Turn::all().filter(fits).find(|&turn| {
        painted.images.iter().all(|levels| {
            levels.iter().enumerate().all(|(level, image)| {
                let [a, b] = [face, of].map(|face| FaceTexels::of_face(painted.layout, face as usize, level));
                let rows = a.turned(turn).rows().zip(b.rows());
                are_equal(image, rows.flat_map(|(a, b)| a.zip(b)))
            })
        })
    })
}

/// The same for faces that a turn lays on each other: of level 0 of all channels.
fn sum(painted: &Painted<'_>, face: usize) -> u64 {
    let texels = FaceTexels::of_face(painted.layout, face, 0);
    let mut sum = 0u64;
    for (channel, levels) in painted.images.iter().enumerate() {
        for texel in texels.rows().flatten() {
            sum = sum.wrapping_add(scatter(codes(&levels[0], texel) ^ (channel as u64) << 59));
        }
    }
    sum
}

fn codes(image: &Image, texel: usize) -> u64 {
    let count = usize::from(image.components);
    let range = texel * count..(texel + 1) * count;
    match &image.pixels {
        Pixels::U8(all) => all[range].iter().fold(0, |word, &code| word << 8 | u64::from(code)),
        Pixels::U16(all) => all[range].iter().fold(0, |word, &code| word << 16 | u64::from(code)),
        Pixels::F32(all) => all.values[range]
            .iter()
            .fold(0, |word: u64, value| word.rotate_left(16) ^ u64::from(value.to_bits())),
    }
}
