//! What compressed blocks of 4 × 4 texels that lie on several blocks of the layout cost, and what a layout that
//! starts all of them on multiples of 4 would: `cargo run --release -p meshcolor-core --example block_straddle --
//! MODEL`, a model in one file. One line for each texture and level, with indexed coordinates and BC7.

use std::collections::BTreeSet;
use std::error::Error;

use meshcolor::finished::{Anchor, BlockTable, Coordinates, Finished, FinishedTexture};
use meshcolor::image::Image;
use meshcolor::pipeline::{BlockFormat, Options, convert_asset};
use meshcolor::read::{Limits, Upload, read};
use meshcolor::watch::Unwatched;
use meshcolor::write::textures::Compressed;

const SIDE: u64 = 4;
/// Nothing is stored here.
const NONE: u32 = u32::MAX;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("a model is missing")?;
    let asset = read(&Upload::single(&path, std::fs::read(&path)?), &Limits::default(), &Unwatched)?;
    let finished = convert_asset(asset, &Options::default(), &Limits::default(), &Unwatched)?.finished;
    let compressed = Compressed::of(&finished, &BTreeSet::from([BlockFormat::Bc7]), &Unwatched)?;
    let decoded = compressed.decoded(&finished)?;
    println!("texture level   of 4 x 4: several   PSNR, dB: several  one    texels, aligned / now");
    for (texture, [source, got]) in
        finished.textures.iter().zip(&decoded.textures).map(|(a, b)| [a, b]).enumerate()
    {
        for (level, image) in source.levels.iter().enumerate() {
            let Some(layout) = Layout::of(&finished, source, level) else { continue };
            let mut several = Mean::default();
            let mut one = Mean::default();
            for y in (0..image.height).step_by(SIDE as usize) {
                for x in (0..image.width).step_by(SIDE as usize) {
                    match layout.block_count(x, y) {
                        0 => {}
                        1 => one.add([image, &got.levels[level]], [x, y]),
                        _ => several.add([image, &got.levels[level]], [x, y]),
                    }
                }
            }
            println!(
                "{texture:7} {level:5} {:17.1} % {:>17} {:>6} {:14.3}",
                100.0 * several.blocks as f64 / (several.blocks + one.blocks) as f64,
                decibels(&several),
                decibels(&one),
                layout.aligned_share
            );
        }
    }
    Ok(())
}

fn decibels(mean: &Mean) -> String {
    mean.psnr_db().map_or("-".to_owned(), |psnr| format!("{psnr:.2}"))
}

/// Whose texels are whose at a level.
struct Layout {
    size: [u32; 2],
    owners: Vec<u32>,
    /// Texels of blocks whose sides are multiples of 4 to those of blocks as they are.
    aligned_share: f64,
}

impl Layout {
    fn of(finished: &Finished, texture: &FinishedTexture, level: usize) -> Option<Self> {
        let size = texture.levels[level].size();
        let mut blocks = BTreeSet::new();
        let mut table: Option<&BlockTable> = None;
        for piece in finished.primitives.iter().filter(|piece| texture.is_of(piece.material, piece.part)) {
            let Coordinates::Indexed(of) = &piece.coordinates else { return None };
            table = Some(of);
            blocks.extend(piece.triangles.iter().filter_map(|triangle| match triangle.anchor {
                Anchor::Block { class, number } => Some((class, number)),
                Anchor::Offset(_) => None,
            }));
        }
        let table = table?;
        let mut owners = vec![NONE; size[0] as usize * size[1] as usize];
        let [mut now, mut aligned] = [0u64; 2];
        for (owner, &(class, number)) in blocks.iter().enumerate() {
            let of = table.classes[class as usize];
            let segments = of.segments(level);
            let sides = [0, 1].map(|k| u64::from(of.cells[k]) * segments[k] + u64::from(of.gap[k]));
            let first = table.first_texel(class, number, level)?;
            now += sides[0] * sides[1];
            aligned += sides.map(|side| side.next_multiple_of(SIDE)).iter().product::<u64>();
            for y in 0..sides[1] {
                let row = (first[1] - u64::from(of.shift[1]) + y) * u64::from(size[0]);
                let start = (row + first[0] - u64::from(of.shift[0])) as usize;
                owners[start..start + sides[0] as usize].fill(owner as u32);
            }
        }
        Some(Self { size, owners, aligned_share: aligned as f64 / now as f64 })
    }

    /// Blocks of the layout under the 4 × 4 texels from here on.
    fn block_count(&self, x: u32, y: u32) -> usize {
        let ends = [x + 4, y + 4];
        let rows = y..ends[1].min(self.size[1]);
        let texels = rows.flat_map(|y| (x..ends[0].min(self.size[0])).map(move |x| (x, y)));
        let owners: BTreeSet<u32> =
            texels.map(|(x, y)| self.owners[(y * self.size[0] + x) as usize]).collect();
        owners.iter().filter(|&&owner| owner != NONE).count()
    }
}

/// Of squared errors, codes.
#[derive(Default)]
struct Mean {
    squares: f64,
    count: usize,
    blocks: usize,
}

impl Mean {
    fn add(&mut self, [image, got]: [&Image; 2], [x, y]: [u32; 2]) {
        self.blocks += 1;
        for y in y..image.height.min(y + 4) {
            for x in x..image.width.min(x + 4) {
                let [a, b] = [image, got].map(|image| image.normalized(x, y));
                self.squares += (0..3).map(|k| (255.0 * f64::from(a[k] - b[k])).powi(2)).sum::<f64>();
                self.count += 3;
            }
        }
    }

    /// Nothing where there is nothing, or nothing is off.
    fn psnr_db(&self) -> Option<f64> {
        (self.squares > 0.0).then(|| 10.0 * (255.0 * 255.0 * self.count as f64 / self.squares).log10())
    }
}
