//! Blocks from anywhere in a level, in an image of their own.

use crate::image::{Image, Pixels};
use crate::write::textures::blocks::{SIDE, TEXELS};

/// Blocks in a row of the image.
const COLUMNS: usize = 64;

/// The texels of one block.
pub struct Tile {
    /// The number of the block in its level.
    pub block: usize,
    /// Row by row; as many codes are in use as the image has components.
    pub texels: [[u8; 4]; TEXELS],
}

/// At least one tile after the other, row by row; what is left of the last row is black.
pub fn beside_each_other(tiles: &[Tile], components: u8) -> Image {
    let columns = tiles.len().min(COLUMNS);
    let [width, height] = [columns * SIDE, tiles.len().div_ceil(columns) * SIDE];
    let count = usize::from(components);
    let mut codes = vec![0; width * height * count];
    for (number, tile) in tiles.iter().enumerate() {
        let first = number / columns * SIDE * width + number % columns * SIDE;
        for (row, texels) in tile.texels.chunks_exact(SIDE).enumerate() {
            let line = &mut codes[(first + row * width) * count..][..SIDE * count];
            for (out, texel) in line.chunks_exact_mut(count).zip(texels) {
                out.copy_from_slice(&texel[..count]);
            }
        }
    }
    Image { width: width as u32, height: height as u32, components, pixels: Pixels::U8(codes) }
}

/// Where texel `k` of a tile stands in the image of all of them: `y · width + x`.
pub fn tile_texel(image: &Image, number: usize, k: usize) -> u32 {
    let columns = image.width as usize / SIDE;
    let (x, y) = (number % columns * SIDE + k % SIDE, number / columns * SIDE + k / SIDE);
    (y * image.width as usize + x) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_are_found_where_they_were_put() {
        for components in 1..=4 {
            let code = |number: usize, k: usize, c: usize| (number * 7 + k * 3 + c) as u8;
            let texels = |number| std::array::from_fn(|k| std::array::from_fn(|c| code(number, k, c)));
            // One row with the last tile alone in the next.
            let tiles: Vec<Tile> = (0..=COLUMNS).map(|block| Tile { block, texels: texels(block) }).collect();
            let image = beside_each_other(&tiles, components);
            assert_eq!(image.size(), [COLUMNS * SIDE, 2 * SIDE].map(|side| side as u32));
            let Pixels::U8(codes) = &image.pixels else { panic!("8 bits") };
            for (number, k) in (0..tiles.len()).flat_map(|number| (0..TEXELS).map(move |k| (number, k))) {
                let count = usize::from(components);
                let found = &codes[tile_texel(&image, number, k) as usize * count..][..count];
                assert_eq!(found, &tiles[number].texels[k][..count], "tile {number}, texel {k}");
            }
        }
    }
}
