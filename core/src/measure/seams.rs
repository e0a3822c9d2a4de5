//! The seams of a conversion: at every level, what the two sides of each edge differ by.

use super::coarse_weights;
use super::edges::{EdgePair, Side};
use super::figures::{Jumps, Survey, survey, surveys};
use super::judge::{Judge, Meaning, Track};
use super::report::{CutShare, Figures};
use super::surface::Surface;
use super::texels::{CLAMPED, Texels};
use crate::error::{Error, Result};
use crate::finished::FinishedTexture;

/// One converted channel over its surface.
pub struct Converted<'a> {
    pub surface: &'a Surface<'a>,
    /// By part of the material; all with as many levels.
    pub textures: Vec<&'a FinishedTexture>,
    pub meaning: Meaning,
    /// By part of the surface, which of the textures it reads.
    reads: Vec<usize>,
}

impl<'a> Converted<'a> {
    /// # Errors
    /// `InvalidModel` where triangles stand in a part that has no texture, and where normals have no frames to stand
    /// in.
    pub fn new(
        surface: &'a Surface<'a>,
        textures: Vec<&'a FinishedTexture>,
        meaning: Meaning,
    ) -> Result<Self> {
        let mut reads = Vec::with_capacity(surface.parts.len());
        for part in &surface.parts {
            let lie = |rule: String| {
                Error::invalid(rule).at(format!("/meshes/{}/primitives/{}", part.mesh, part.primitive))
            };
            let own = textures.iter().position(|texture| texture.part == part.part());
            let lacks =
                || lie(format!("part {} of material {} has no texture", part.part(), surface.material));
            reads.push(own.ok_or_else(lacks)?);
            let is_normal = matches!(meaning, Meaning::Normal { .. });
            if is_normal && part.frames().len() != part.triangles.len() {
                return Err(lie("a converted normal map needs NORMAL and TANGENT".to_owned()));
            }
        }
        Ok(Self { surface, textures, meaning, reads })
    }

    pub fn level_count(&self) -> usize {
        self.textures.iter().map(|texture| texture.levels.len()).min().unwrap_or(0)
    }

    /// The jumps on the pairs with the given indices.
    pub fn survey(&self, level: usize, which: &[u32]) -> Survey {
        let judge = self.judge(level);
        survey(&self.surface.pairs, which, |pair| {
            let [a, b] = self.tracks(pair, level);
            let [exact, _] = judge.jumps(&a, &b, false);
            exact.unwrap_or(Jumps::Nothing)
        })
    }

    /// The same as figures, and those of weights of 8 bits over the pairs that have a face beyond vertex
    /// colors on a side. `None` where there are no such pairs.
    pub fn figures(&self, level: usize, which: &[u32]) -> [Option<Figures>; 2] {
        let judge = self.judge(level);
        let surveys = surveys(&self.surface.pairs, which, |pair| {
            let [a, b] = self.tracks(pair, level);
            judge.jumps(&a, &b, coarse_weights::is_beyond(self.surface, pair, level))
        });
        surveys.map(|survey| (survey.figures.sample_count > 0).then_some(survey.figures))
    }

    fn judge(&self, level: usize) -> Judge<'_> {
        let components = self.textures.first().map_or(0, |texture| texture.levels[level].components);
        let images = (0..self.textures.len()).map(|number| self.image(number, level)).collect();
        Judge { images, meaning: self.meaning, components }
    }

    /// Which of the textures a part of the surface reads.
    pub fn texture_of(&self, part: usize) -> usize {
        self.reads[part]
    }

    /// A level as a part of the surface samples it.
    pub fn texels(&self, part: usize, level: usize) -> Texels<'_> {
        self.image(self.reads[part], level)
    }

    fn image(&self, number: usize, level: usize) -> Texels<'_> {
        let texture = self.textures[number];
        Texels::new(&texture.levels[level], self.meaning.transfer(), CLAMPED)
            .in_range(texture.ranges.get(&level))
    }

    /// Both sides of a pair, in the direction of the first.
    fn tracks(&self, pair: &EdgePair, level: usize) -> [Track; 2] {
        [self.track(&pair.a, pair.a.ends(), level), self.track(&pair.b, pair.ends_of_b(), level)]
    }

    fn track(&self, side: &Side, ends: [usize; 2], level: usize) -> Track {
        let part = self.surface.part(side);
        let triangle = &part.placed[side.triangle as usize];
        let map = part.coordinates.map(triangle.anchor, level);
        let frames = matches!(self.meaning, Meaning::Normal { .. })
            .then(|| ends.map(|k| part.frames()[side.triangle as usize][k]));
        let [from, to] = ends.map(|end| triangle.corners[end]);
        let image = self.reads[side.part as usize];
        Track { image, from, to, scale: map.scale, shift: map.shift, frames, tints: None }
    }
}

/// The pairs that are not cut.
pub fn uncut(cut_flags: &[bool]) -> Vec<u32> {
    (0..cut_flags.len() as u32).filter(|&pair| !cut_flags[pair as usize]).collect()
}

/// Shares of seam length, and counts, by edge: an edge of several pairs is a seam, or cut, when one of
/// its pairs is.
pub fn cut_share(surface: &Surface<'_>, seam: &[u32], cut_flags: &[bool]) -> CutShare {
    let mut is_seam = vec![false; surface.pairs.len()];
    seam.iter().for_each(|&pair| is_seam[pair as usize] = true);
    let mut share = CutShare::default();
    let (mut inner, mut seams, mut cut_seams) = (0.0, 0.0, 0.0);
    let mut start = 0;
    for edge in surface.pairs.chunk_by(|x: &EdgePair, y| x.a == y.a) {
        let range = start..start + edge.len();
        start = range.end;
        let length = f64::from(edge[0].length);
        let (seam, cut) = (is_seam[range.clone()].contains(&true), cut_flags[range].contains(&true));
        inner += length;
        share.cut_edge_count += u64::from(cut);
        if seam {
            share.seam_edge_count += 1;
            seams += length;
            cut_seams += if cut { length } else { 0.0 };
        }
    }
    if seams > 0.0 {
        share.seam_share = seams / inner;
        share.cut_share = cut_seams / seams;
        share.welded_share = 1.0 - share.cut_share;
    }
    share
}

#[cfg(test)]
mod tests;
