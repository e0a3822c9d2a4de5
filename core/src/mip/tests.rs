use glam::{Vec3, Vec4};

use super::{Beyond, Coarsener, MipFilter, Rungs, coverage, keep_coverage};
use crate::colors::{ChannelTopology, Cuts, LevelNumbering, Resolutions, SampleAreas};
use crate::mesh::{CanvasMesh, Polygons, build};
use crate::watch::Unwatched;

pub(super) const PLAIN: Rungs =
    Rungs { filter: MipFilter::Uniform, beyond: Beyond::OneRing, by_alpha: false };
pub(super) const BY_ALPHA: Rungs = Rungs { by_alpha: true, ..PLAIN };

pub(super) fn canvas(positions: &[Vec3], faces: &[&[u32]]) -> CanvasMesh {
    let mut iterator = faces.iter().map(|face| {
        let mut corners = [0; 4];
        corners[..face.len()].copy_from_slice(face);
        (corners, face.len() as u8)
    });
    build([Polygons { mesh: 0, primitive: 0, positions, faces: &mut iterator }])
}

/// A closed fan of `valence` triangles around vertex 0.
pub(super) fn fan(valence: u32) -> CanvasMesh {
    let rim = (0..valence).map(|k| {
        let angle = k as f32 / valence as f32 * std::f32::consts::TAU;
        Vec3::new(angle.cos(), angle.sin(), 0.0)
    });
    let positions: Vec<Vec3> = std::iter::once(Vec3::ZERO).chain(rim).collect();
    let faces: Vec<[u32; 3]> = (0..valence).map(|k| [0, 1 + k, 1 + (k + 1) % valence]).collect();
    canvas(&positions, &faces.iter().map(|face| face.as_slice()).collect::<Vec<_>>())
}

/// Filters one level of the given samples; `value` by sample number.
fn one_level(canvas: &CanvasMesh, exponents: &[u8], cuts: &Cuts, value: impl Fn(usize) -> f32) -> Vec<f32> {
    let resolutions = Resolutions::uniform(exponents.iter().copied());
    let topology = ChannelTopology::new(canvas, &resolutions, cuts);
    let fine = LevelNumbering::new(canvas, &topology, &resolutions, 0);
    let coarse = LevelNumbering::new(canvas, &topology, &resolutions, 1);
    let values: Vec<Vec4> = (0..fine.sample_count()).map(|sample| Vec4::splat(value(sample))).collect();
    let out = Coarsener::new(PLAIN).coarsen([&fine, &coarse], &values, Vec::new(), &Unwatched).unwrap();
    assert_eq!(out.len(), coarse.sample_count());
    out.into_iter().map(|v| v.x).collect()
}

/// Every rung there is.
pub(super) const RUNGS: [Rungs; 4] = [
    PLAIN,
    Rungs { filter: MipFilter::Area, ..PLAIN },
    Rungs { beyond: Beyond::Heat, ..PLAIN },
    Rungs { filter: MipFilter::Area, beyond: Beyond::Heat, ..PLAIN },
];

/// A mesh with the samples of its levels.
pub(super) struct Case {
    pub canvas: CanvasMesh,
    pub resolutions: Resolutions,
    pub cuts: Cuts,
}

impl Case {
    pub fn new(canvas: CanvasMesh, exponents: Vec<u8>) -> Self {
        Self::elongated(canvas, Resolutions::uniform(exponents))
    }

    pub fn elongated(canvas: CanvasMesh, resolutions: Resolutions) -> Self {
        let cuts = Cuts::none(&canvas);
        Self { canvas, resolutions, cuts }
    }

    pub fn topology(&self) -> ChannelTopology {
        ChannelTopology::new(&self.canvas, &self.resolutions, &self.cuts)
    }

    pub fn sample_count(&self) -> usize {
        self.level(&self.topology(), 0).sample_count()
    }

    pub fn level<'a>(&'a self, topology: &'a ChannelTopology, level: usize) -> LevelNumbering<'a> {
        LevelNumbering::new(&self.canvas, topology, &self.resolutions, level)
    }

    /// Of every sample.
    pub fn areas(&self, level: usize) -> Vec<f32> {
        let topology = self.topology();
        let numbering = self.level(&topology, level);
        let areas = SampleAreas::new(&numbering);
        (0..numbering.sample_count()).map(|sample| areas.of(&numbering, sample)).collect()
    }

    /// The samples of levels 0 to `last`.
    pub fn levels(&self, samples: &[Vec4], rungs: Rungs, last: usize) -> Vec<Vec<Vec4>> {
        let topology = self.topology();
        let mut coarsener = Coarsener::new(rungs);
        let mut levels = vec![samples.to_vec()];
        for level in 1..=last {
            let (fine, coarse) = (self.level(&topology, level - 1), self.level(&topology, level));
            let before = &levels[level - 1];
            levels.push(coarsener.coarsen([&fine, &coarse], before, Vec::new(), &Unwatched).unwrap());
        }
        levels
    }
}

/// A small generator of our own: the same cases everywhere.
pub(super) struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    pub fn below(&mut self, end: usize) -> usize {
        (self.next() * end as f32) as usize % end
    }

    pub fn colors(&mut self, count: usize) -> Vec<Vec4> {
        (0..count).map(|_| Vec4::new(self.next(), self.next(), self.next(), self.next())).collect()
    }
}

/// A sheet of `side * side` cells of quads and triangles, corners moved by up to `bend`; exponents below
/// `exponent_end`.
pub(super) fn sheet(random: &mut Random, side: usize, bend: f32, exponent_end: usize) -> Case {
    let mut positions = Vec::new();
    for y in 0..=side {
        for x in 0..=side {
            let mut moved = |v: f32| v + (random.next() - 0.5) * 2.0 * bend;
            positions.push(Vec3::new(moved(x as f32), moved(y as f32), moved(0.0)));
        }
    }
    let mut faces: Vec<Vec<u32>> = Vec::new();
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        let [a, b, c, d] =
            [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)].map(|(x, y)| (y * (side + 1) + x) as u32);
        match random.below(4) {
            0 => faces.push(vec![a, b, c, d]),
            1 => faces.extend([vec![a, b, d], vec![c, d, b]]),
            _ => faces.extend([vec![a, b, c], vec![d, a, c]]),
        }
    }
    let exponents = faces.iter().map(|face| {
        let [r, s] = [(); 2].map(|()| random.below(exponent_end) as u8);
        if face.len() == 3 { [r; 2] } else { [r, s] }
    });
    let resolutions = Resolutions { faces: exponents.collect() };
    Case::elongated(canvas(&positions, &faces.iter().map(Vec::as_slice).collect::<Vec<_>>()), resolutions)
}

#[test]
fn a_constant_stays_what_it_is_on_any_mix_of_exponents() {
    let mesh = fan(5);
    for exponents in [[0, 0, 0, 0, 0], [3, 3, 3, 3, 3], [0, 3, 1, 2, 4]] {
        for (rungs, by_alpha) in RUNGS.into_iter().flat_map(|rungs| [(rungs, false), (rungs, true)]) {
            let case = Case::new(mesh.clone(), exponents.to_vec());
            let rungs = Rungs { by_alpha, ..rungs };
            for level in case.levels(&vec![Vec4::splat(0.7); case.sample_count()], rungs, 20) {
                let error = level.iter().map(|v| (*v - 0.7).abs().max_element()).fold(0.0, f32::max);
                assert!(error < 3e-6, "{exponents:?}, {rungs:?}: {error}");
            }
        }
    }
}

/// MC equation 6: a vertex of valence v keeps 1 / (1 + v/2) of itself.
#[test]
fn a_vertex_weighs_itself_by_its_valence() {
    for valence in [3u32, 4, 7, 100] {
        let mesh = fan(valence);
        for exponent in [0, 2] {
            let exponents = vec![exponent; valence as usize];
            let out = one_level(&mesh, &exponents, &Cuts::none(&mesh), |sample| f32::from(sample == 0));
            let expected = 1.0 / (1.0 + valence as f32 / 2.0);
            assert!((out[0] - expected).abs() < 1e-6, "valence {valence}, exponent {exponent}: {}", out[0]);
        }
    }
}

/// MC equation 5 inside a triangle, and its counterpart on a quad: the middle weighs 1/4.
#[test]
fn inner_samples_weigh_their_neighbors() {
    let triangle = canvas(&[Vec3::ZERO, Vec3::X, Vec3::Y], &[&[0, 1, 2]]);
    let resolutions = Resolutions::uniform(vec![3]);
    let topology = ChannelTopology::new(&triangle, &resolutions, &Cuts::none(&triangle));
    let fine = LevelNumbering::new(&triangle, &topology, &resolutions, 0);
    let coarse = LevelNumbering::new(&triangle, &topology, &resolutions, 1);
    let center = coarse.tap(0, 1, 1).samples[0] as usize;
    for (i, j, expected) in
        [(2, 2, 0.25), (3, 2, 0.125), (1, 2, 0.125), (3, 1, 0.125), (3, 3, 0.0), (1, 1, 0.0)]
    {
        let lit = fine.tap(0, i, j).samples[0] as usize;
        let out = one_level(&triangle, &[3], &Cuts::none(&triangle), |sample| f32::from(sample == lit));
        assert!((out[center] - expected).abs() < 1e-6, "({i}, {j}) weighs {}", out[center]);
    }
    let quad = canvas(&[Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y], &[&[0, 1, 2, 3]]);
    let resolutions = Resolutions::uniform(vec![2]);
    let topology = ChannelTopology::new(&quad, &resolutions, &Cuts::none(&quad));
    let fine = LevelNumbering::new(&quad, &topology, &resolutions, 0);
    let coarse = LevelNumbering::new(&quad, &topology, &resolutions, 1);
    let center = coarse.tap(0, 1, 1).samples[0] as usize;
    for (i, j, expected) in [(2, 2, 0.25), (1, 2, 0.125), (3, 3, 0.0625)] {
        let lit = fine.tap(0, i, j).samples[0] as usize;
        let out = one_level(&quad, &[2], &Cuts::none(&quad), |sample| f32::from(sample == lit));
        assert!((out[center] - expected).abs() < 1e-6, "({i}, {j}) weighs {}", out[center]);
    }
}

/// An edge sample takes half of two neighbors on the edge and of two in each face (MC 4.2).
#[test]
fn edge_samples_take_from_both_faces_unless_cut() {
    let mesh = canvas(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0)], &[&[0, 1, 2], &[3, 2, 1]]);
    let resolutions = Resolutions::uniform(vec![2, 2]);
    let shared = mesh.edges.iter().position(|edge| edge.vertices == [1, 2]).unwrap();
    for is_cut in [false, true] {
        let mut cuts = Cuts::none(&mesh);
        cuts.edges[shared] = is_cut;
        let topology = ChannelTopology::new(&mesh, &resolutions, &cuts);
        let fine = LevelNumbering::new(&mesh, &topology, &resolutions, 0);
        let coarse = LevelNumbering::new(&mesh, &topology, &resolutions, 1);
        let middle = coarse.edge_tap(0, 1, 1).samples[0] as usize;
        let lit: Vec<usize> = fine.face_range(1).collect();
        let out = one_level(&mesh, &[2, 2], &cuts, |sample| f32::from(lit.contains(&sample)));
        // Of the other face's three inner samples two lie beside the middle of the edge.
        let expected = if is_cut { 0.0 } else { 0.25 };
        assert!((out[middle] - expected).abs() < 1e-6, "cut {is_cut}: {}", out[middle]);
    }
}

#[test]
fn what_is_transparent_has_no_vote_in_color() {
    let mesh = fan(4);
    let resolutions = Resolutions::uniform(vec![0; 4]);
    let topology = ChannelTopology::new(&mesh, &resolutions, &Cuts::none(&mesh));
    let fine = LevelNumbering::new(&mesh, &topology, &resolutions, 0);
    let coarse = LevelNumbering::new(&mesh, &topology, &resolutions, 1);
    let clear_green = Vec4::new(0.0, 1.0, 0.0, 0.0);
    let mut coarsener = Coarsener::new(BY_ALPHA);
    let mut values = vec![clear_green; 5];
    values[0] = Vec4::new(1.0, 0.0, 0.0, 1.0);
    let out = coarsener.coarsen([&fine, &coarse], &values, Vec::new(), &Unwatched).unwrap();
    assert!(out[0].x > 0.99 && out[0].y < 0.01, "{:?}", out[0]);
    assert!((out[0].w - 1.0 / 3.0).abs() < 1e-6);
    values[0] = clear_green;
    let out = coarsener.coarsen([&fine, &coarse], &values, Vec::new(), &Unwatched).unwrap();
    assert!((out[0] - clear_green).abs().max_element() < 1e-6, "hidden color is kept where nothing shows");
}

#[test]
fn a_mask_keeps_its_share_of_surface() {
    let mesh = fan(6);
    let resolutions = Resolutions::uniform(vec![3; 6]);
    let topology = ChannelTopology::new(&mesh, &resolutions, &Cuts::none(&mesh));
    let numbering = LevelNumbering::new(&mesh, &topology, &resolutions, 0);
    let sharp: Vec<Vec4> =
        (0..numbering.sample_count()).map(|k| Vec4::splat(if k % 4 == 0 { 1.0 } else { 0.0 })).collect();
    let wanted = coverage(&numbering, &sharp, 0.5, &Unwatched).unwrap();
    assert!((0.05..0.5).contains(&wanted), "{wanted}");
    // A filter pulled alpha to the middle: nothing would pass.
    let mut blurred: Vec<Vec4> = sharp.iter().map(|v| *v * 0.2 + Vec4::splat(0.2)).collect();
    assert_eq!(coverage(&numbering, &blurred, 0.5, &Unwatched), Ok(0.0));
    keep_coverage(&numbering, &mut blurred, (0.5, wanted), &Unwatched).unwrap();
    let kept = coverage(&numbering, &blurred, 0.5, &Unwatched).unwrap();
    assert!((kept - wanted).abs() <= 0.01, "{kept}, not {wanted}");
}
