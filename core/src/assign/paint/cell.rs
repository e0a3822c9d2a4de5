//! Rounding four texels together. Beyond vertex colors a face is a small place between four texels, so what
//! it shows is a mix of their rounding errors. Each may be rounded up or down; the choice that shows least
//! at the face's corners leaves a fraction of a code, where four nearest codes leave up to half of one.

use glam::{DVec2, Vec4};

use crate::assign::codec::LevelCodec;

/// Four texels around a face.
pub(super) struct Cell {
    /// The weight of each texel at each corner of the face; with three corners the first one counts twice.
    weights: [Vec4; 4],
}

impl Cell {
    /// Corners on the square between the texels (0, 0), (1, 0), (0, 1), (1, 1).
    pub fn new(corners: &[DVec2]) -> Option<Self> {
        let first = corners.first()?;
        let corner = |k: usize| corners.get(k).unwrap_or(first).as_vec2();
        let corners = [0, 1, 2, 3].map(corner);
        let weight = |[x, y]: [usize; 2]| {
            let axis = |at: f32, far: usize| if far == 1 { at } else { 1.0 - at };
            Vec4::from_array(corners.map(|corner| axis(corner.x, x) * axis(corner.y, y)))
        };
        Some(Self { weights: [[0, 0], [1, 0], [0, 1], [1, 1]].map(weight) })
    }

    /// The codes of one component, given the values that the texels should have.
    pub fn codes(&self, codec: &LevelCodec, component: usize, wanted: [f32; 4]) -> [u16; 4] {
        let choices = wanted.map(|value| codec.around(component, value));
        // What each choice of each texel shows at the corners.
        let shown: [[Vec4; 2]; 4] = std::array::from_fn(|k| {
            choices[k].map(|code| self.weights[k] * (codec.decode_one(component, code) - wanted[k]))
        });
        let pairs =
            |a: usize, b: usize| [0, 1, 2, 3].map(|bits: usize| shown[a][bits & 1] + shown[b][bits >> 1]);
        let (upper, lower) = (pairs(0, 1), pairs(2, 3));
        let mut best = (f32::INFINITY, 0);
        for bits in 0..16 {
            let worst = (upper[bits & 3] + lower[bits >> 2]).abs().max_element();
            if worst < best.0 {
                best = (worst, bits);
            }
        }
        std::array::from_fn(|k| choices[k][best.1 >> k & 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assign::Codec;
    use crate::image::{LevelRange, Transfer};

    /// What a corner shows, against what it should.
    fn worst(codec: &LevelCodec, corners: &[DVec2], wanted: [f32; 4], codes: [u16; 4]) -> f32 {
        let of = |at: &DVec2| {
            let (x, y) = (at.x as f32, at.y as f32);
            let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
            (0..4).map(|k| weights[k] * (codec.decode_one(0, codes[k]) - wanted[k])).sum::<f32>().abs()
        };
        corners.iter().map(of).fold(0.0, f32::max)
    }

    #[test]
    fn four_texels_together_show_less_than_four_nearest_codes() {
        let plain = |transfer| Codec { transfer, components: 1, bits: 8 };
        let range = |range| LevelCodec { plain: plain(Transfer::Srgb), range: Some(range) };
        let codecs = [
            LevelCodec { plain: plain(Transfer::Linear), range: None },
            LevelCodec { plain: plain(Transfer::Srgb), range: None },
            range(LevelRange::spanning(Vec4::splat(-3.0), Vec4::splat(7.0))),
            range(LevelRange::Float16),
        ];
        let corners = [(0.30, 0.60), (0.36, 0.60), (0.30, 0.66)].map(|(x, y)| DVec2::new(x, y));
        let Some(cell) = Cell::new(&corners) else { panic!("three corners") };
        for codec in codecs {
            let mut sums = [0.0; 2];
            for step in 0..200u32 {
                let wanted = [13, 17, 29, 41].map(|k| 0.2 + 0.6 * ((step * k % 97) as f32 / 97.3));
                let together = worst(&codec, &corners, wanted, cell.codes(&codec, 0, wanted));
                let nearest = wanted.map(|value| codec.encode_one(0, value));
                let apart = worst(&codec, &corners, wanted, nearest);
                assert!(together <= apart + 1e-9, "{codec:?}: {together} {apart}");
                sums[0] += together;
                sums[1] += apart;
            }
            assert!(sums[0] < 0.5 * sums[1], "{codec:?}: {sums:?}");
        }
    }

    #[test]
    fn values_that_can_be_stored_stay() {
        let codec =
            LevelCodec { plain: Codec { transfer: Transfer::Linear, components: 1, bits: 8 }, range: None };
        let Some(cell) = Cell::new(&[DVec2::new(0.5, 0.5)]) else { panic!("one corner") };
        assert_eq!(cell.codes(&codec, 0, [0.0, 1.0, 7.0 / 255.0, 2.0]), [0, 255, 7, 255]);
        assert!(Cell::new(&[]).is_none());
    }
}
