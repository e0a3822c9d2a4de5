//! A texture with its levels, borrowed from the conversion where it stands there already.

use std::borrow::Cow;
use std::collections::BTreeMap;

use meshcolor::asset::Asset;
use meshcolor::finished::Finished;
use meshcolor::image::{Image, LevelRange, Transfer};

use super::mips::mip_maps;

/// Level images, level 0 first. A source's are its mip maps, a converted texture's are its own.
pub struct Texture<'a> {
    pub transfer: Transfer,
    pub levels: Vec<Cow<'a, Image>>,
    /// Of a converted texture: levels that hold other values than codes of [0, 1].
    pub ranges: BTreeMap<usize, LevelRange>,
}

impl Texture<'_> {
    pub fn level(&self, level: usize) -> &Image {
        &self.levels[level.min(self.levels.len() - 1)]
    }

    pub fn range(&self, level: usize) -> Option<&LevelRange> {
        self.ranges.get(&level.min(self.levels.len() - 1))
    }
}

/// All textures of both sides: the converted ones first, in the order of `Finished::textures`, then
/// the source's as they are asked for.
pub struct TextureList<'a> {
    asset: &'a Asset,
    pub textures: Vec<Texture<'a>>,
    /// Source image and whether it is read as color, to its number in `textures`.
    sources: BTreeMap<(usize, bool), usize>,
}

impl<'a> TextureList<'a> {
    pub fn new(asset: &'a Asset, finished: &'a Finished) -> Self {
        let converted = finished.textures.iter().map(|texture| Texture {
            transfer: texture.transfer,
            levels: texture.levels.iter().map(Cow::Borrowed).collect(),
            ranges: texture.ranges.clone(),
        });
        Self { asset, textures: converted.collect(), sources: BTreeMap::new() }
    }

    /// The number of a source image with its mip maps.
    pub fn source(&mut self, image: usize, is_color: bool) -> usize {
        let Self { asset, textures, sources } = self;
        *sources.entry((image, is_color)).or_insert_with(|| {
            let transfer = if is_color { Transfer::Srgb } else { Transfer::Linear };
            let finest = &asset.images[image];
            let levels = std::iter::once(Cow::Borrowed(finest))
                .chain(mip_maps(finest, transfer).into_iter().map(Cow::Owned))
                .collect();
            textures.push(Texture { transfer, levels, ranges: BTreeMap::new() });
            textures.len() - 1
        })
    }
}
