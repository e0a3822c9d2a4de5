//! Where a picture should look: the edge on which the source's mip maps come apart most although its
//! level 0 agrees, and which the conversion joins.

use glam::Vec3;

use super::edges::EdgePair;
use super::origin::SourceSeams;
use super::report::Unit;
use super::surface::Surface;
use crate::asset::Slot;

/// Levels whose jumps count: near enough that a viewer shows them, far enough that they have come apart.
const LEVELS: std::ops::RangeInclusive<usize> = 2..=5;

/// Edges shorter than this share of their mesh's diagonal lose to any longer one: nothing to see there.
const SHORTEST_SHARE: f32 = 0.01;

/// A jump that is worth a picture, mean over the edge and the levels.
const VISIBLE_CODES: f32 = 1.0;

/// A place on a seam of the source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    pub mesh: usize,
    pub primitive: usize,
    /// Middle and ends of the edge in mesh space.
    pub position: Vec3,
    pub ends: [Vec3; 2],
    /// Mean of the normals of the faces at the edge, mesh space, unit length.
    pub normal: Vec3,
    /// Material channel that shows it most, an index into `Finished::textures`.
    pub texture: usize,
    /// Jump of the source at each of its levels, codes, mean along the edge. A chain that ends earlier
    /// repeats its last.
    pub source_jumps_codes: [f32; 8],
}

/// What a channel is to a viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Attribute,
    Other,
    BaseColor,
}

impl Kind {
    pub fn of(slots: &[Slot]) -> Self {
        if slots.contains(&Slot::BaseColor) {
            Self::BaseColor
        } else if slots.iter().all(Slot::is_attribute) {
            Self::Attribute
        } else {
            Self::Other
        }
    }
}

/// A channel's best edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    pub focus: Focus,
    kind: Kind,
    /// Whether the edge is long enough to see.
    is_long: bool,
    /// Mean jump over [`LEVELS`], codes.
    jump_codes: f32,
    /// `jump_codes` times the square root of the length.
    score: f32,
}

impl Candidate {
    /// What a viewer shows before what it does not, base color before others where there is anything to see; then long edges; then
    /// the score.
    fn rank(&self) -> (Kind, bool, f32) {
        let is_visible = self.jump_codes >= VISIBLE_CODES;
        let kind = if is_visible { self.kind } else { self.kind.min(Kind::Other) };
        (kind, is_visible && self.is_long, self.score)
    }

    /// The better of two, the first where they are equal.
    pub fn better(first: Option<Self>, second: Option<Self>) -> Option<Self> {
        let (Some(a), Some(b)) = (first, second) else { return first.or(second) };
        let ((kind_a, long_a, score_a), (kind_b, long_b, score_b)) = (a.rank(), b.rank());
        let order = (kind_a, long_a).cmp(&(kind_b, long_b)).then(score_a.total_cmp(&score_b));
        if order.is_lt() { second } else { first }
    }
}

/// The best edge of one channel: among those that agree at level 0 and that `cut_flags` does not name. `texture` is the
/// one that a part of the surface reads.
pub fn candidate(
    surface: &Surface<'_>,
    seams: &SourceSeams,
    cut_flags: &[bool],
    texture: &impl Fn(usize) -> usize,
    (unit, kind): (Unit, Kind),
) -> Option<Candidate> {
    if unit != Unit::Codes || seams.levels.is_empty() {
        return None;
    }
    let diagonals: Vec<f32> = surface.parts.iter().map(|part| mesh_diagonal(surface, part.mesh)).collect();
    let mut best = None;
    for &at in &seams.agreed {
        let pair = &surface.pairs[seams.seam[at as usize] as usize];
        if cut_flags[seams.seam[at as usize] as usize] {
            continue;
        }
        let last = seams.levels.len() - 1;
        let jumps = std::array::from_fn(|level| seams.levels[level.min(last)].survey.edge_means[at as usize]);
        let jump_codes = jumps[LEVELS].iter().sum::<f32>() / LEVELS.count() as f32;
        let found = Candidate {
            focus: place(surface, pair, texture(pair.a.part as usize), jumps),
            kind,
            is_long: pair.length >= SHORTEST_SHARE * diagonals[pair.a.part as usize],
            jump_codes,
            score: jump_codes * pair.length.sqrt(),
        };
        best = Candidate::better(best, Some(found));
    }
    best
}

fn mesh_diagonal(surface: &Surface<'_>, mesh: usize) -> f32 {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for part in surface.parts.iter().filter(|part| part.mesh == mesh) {
        for position in &part.geometry.positions {
            (low, high) = (low.min(*position), high.max(*position));
        }
    }
    (high - low).length()
}

fn place(surface: &Surface<'_>, pair: &EdgePair, texture: usize, source_jumps_codes: [f32; 8]) -> Focus {
    let part = surface.part(&pair.a);
    let corners = part.corners(pair.a.triangle as usize);
    let ends = pair.a.ends().map(|k| corners[k]);
    let normals = [&pair.a, &pair.b].map(|side| {
        let [a, b, c] = surface.part(side).corners(side.triangle as usize).map(|corner| corner.as_dvec3());
        (b - a).cross(c - a).normalize_or_zero().as_vec3()
    });
    Focus {
        mesh: part.mesh,
        primitive: part.primitive,
        position: ends[0].midpoint(ends[1]),
        ends,
        normal: (normals[0] + normals[1])
            .try_normalize()
            .or_else(|| normals[0].try_normalize())
            .unwrap_or(Vec3::Z),
        texture,
        source_jumps_codes,
    }
}
