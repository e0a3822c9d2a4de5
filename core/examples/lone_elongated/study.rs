//! One model's lone triangles with one exponent and with two.

use glam::DVec3;
use meshcolor::image::Transfer;
use meshcolor::math::transfer::linear_to_srgb;
use meshcolor::source::SurfaceSource;

use crate::figures::Figures;
use crate::model::{Elongated, Surface};
use crate::slanted::{Grid, Triangle};

/// Places along a side at which a face is held against its source.
const PLACES: usize = 28;
/// Between two samples of the diagonal.
const STEPS: i32 = 8;
const UNIT: [f64; 2] = [0.0, 1.0];

/// What is counted over all elongated lone triangles of a model.
#[derive(Default)]
pub struct Study {
    pub triangle_count: usize,
    pub lone_count: usize,
    pub elongated_count: usize,
    /// Those whose diagonal no channel joins to a neighbor.
    pub free_count: usize,
    /// Of all faces.
    pub texels: f64,
    pub by_rule: ByRule,
    pub at_equal_error: AtEqualError,
    pub cost: Cost,
}

/// Texels of elongated lone triangles, and their squared error in codes, weighted by area.
#[derive(Default)]
pub struct ByRule {
    pub one_texels: f64,
    pub two_texels: f64,
    pub weight: f64,
    /// With one exponent, by the paper's rule, by the exact one.
    pub squared: [f64; 3],
}

/// The fewest texels that show what the rule's one exponent shows.
#[derive(Default)]
pub struct AtEqualError {
    pub one_texels: f64,
    pub paper_texels: f64,
    pub exact_texels: f64,
    /// With two exponents where the diagonal is free, which needs neither rule; else with one.
    pub free_texels: f64,
}

/// Codes, where the diagonal is bound to a neighbor.
#[derive(Default)]
pub struct Cost {
    pub jump: Figures,
    /// What the diagonal's samples change by to keep texels in range.
    pub paper_change: Figures,
    pub exact_change: Figures,
}

impl Study {
    pub fn add(&mut self, surface: &Surface<'_>) {
        self.triangle_count += surface.canvas.faces.iter().map(|face| face.count() - 2).sum::<usize>();
        self.lone_count += surface.lone_count();
        self.texels += surface.texels();
        for one in surface.elongated() {
            self.elongated_count += 1;
            self.free_count += usize::from(!one.is_bound.contains(&true));
            self.add_one(surface, &one);
        }
    }

    fn add_one(&mut self, surface: &Surface<'_>, one: &Elongated) {
        let faces: Vec<Face<'_>> =
            surface.sources.iter().map(|source| Face { surface, source, one }).collect();
        let error = |exponents: [u8; 2], rule: Rule| -> f64 {
            faces.iter().map(|face| face.squared_error(&rule.of(face.triangle(exponents)))).sum()
        };
        let (same, wanted) = ([one.one_exponent; 2], one.two_exponents);
        let reference = error(same, Rule::Exact);
        let area = f64::from(surface.canvas.faces[one.face].area);
        let count = faces.len() as f64;
        let squared = [reference, error(wanted, Rule::Paper), error(wanted, Rule::Exact)];
        let by_rule = &mut self.by_rule;
        by_rule.one_texels += Grid::new(same).texels();
        by_rule.two_texels += Grid::new(wanted).texels();
        by_rule.weight += area * count;
        by_rule.squared.iter_mut().zip(squared).for_each(|(sum, squared)| *sum += area * squared);

        let cheapest = |most: f64, rule: Rule, is_elongated: bool| {
            let all = candidates(one).filter(|[r, s]| is_elongated == (r > s));
            let cheaper = all.filter(|&exponents| Grid::new(exponents).texels() < most);
            let enough = cheaper.filter(|&exponents| error(exponents, rule) <= reference);
            enough.map(|exponents| Grid::new(exponents).texels()).fold(most, f64::min)
        };
        let least = cheapest(Grid::new(same).texels(), Rule::Exact, false);
        let at_equal_error = &mut self.at_equal_error;
        let paper = cheapest(least, Rule::Paper, true);
        at_equal_error.one_texels += least;
        at_equal_error.paper_texels += paper;
        at_equal_error.exact_texels += cheapest(least, Rule::Exact, true);
        at_equal_error.free_texels += if one.is_bound.contains(&true) { least } else { paper };

        for (face, _) in faces.iter().zip(&one.is_bound).filter(|(_, is_bound)| **is_bound) {
            let codes = |value: DVec3| face.codes(value);
            self.cost.add(&face.triangle(wanted), codes, face.component_count());
        }
    }
}

/// How the texels about the diagonal are made.
#[derive(Clone, Copy)]
enum Rule {
    Paper,
    Exact,
}

impl Rule {
    fn of(self, samples: Triangle) -> Triangle {
        match self {
            Rule::Paper => samples.paper(Some(UNIT)),
            Rule::Exact => samples.exact(),
        }
    }
}

/// As long as the rule makes the long leg, or twice; never wider than long.
fn candidates(one: &Elongated) -> impl Iterator<Item = [u8; 2]> {
    let longest = one.two_exponents[0].max(one.one_exponent) + 1;
    (0..=longest).flat_map(|r| (0..=r).map(move |s| [r, s]))
}

impl Cost {
    pub fn add(&mut self, samples: &Triangle, codes: impl Fn(DVec3) -> DVec3, component_count: usize) {
        let paper = samples.clone().paper(Some(UNIT));
        for (i, step) in (0..samples.grid.n).flat_map(|i| (1..STEPS).map(move |step| (i, step))) {
            let [own, other] = paper.both_sides(i, f64::from(step) / f64::from(STEPS));
            self.jump.add(codes(own) - codes(other), component_count);
        }
        for (old, new) in samples.diagonal.iter().zip(&paper.diagonal) {
            self.paper_change.add(codes(*old) - codes(*new), component_count);
        }
        for (old, new) in samples.samples().zip(samples.clone().exact().samples()) {
            self.exact_change.add(codes(old) - codes(new), component_count);
        }
    }
}

/// An elongated triangle in one channel.
struct Face<'a> {
    surface: &'a Surface<'a>,
    source: &'a SurfaceSource<'a>,
    one: &'a Elongated,
}

impl Face<'_> {
    /// The source at shares of the long and of the short leg: linear light or data. Normals are vectors of object space, and
    /// stand around 1/2 as stored ones do.
    fn source(&self, [along, across]: [f64; 2]) -> DVec3 {
        let mut weights = [0.0; 3];
        let of_corners = [1.0 - along - across, along, across];
        self.one.corners.into_iter().zip(of_corners).for_each(|(corner, weight)| weights[corner] = weight);
        let [_, s, t] = weights.map(|weight| weight as f32);
        let value = self.source.at(&self.surface.canvas, self.one.face, s, t).truncate().as_dvec3();
        if self.source.channel.is_normal() { value * 0.5 + 0.5 } else { value }
    }

    fn triangle(&self, exponents: [u8; 2]) -> Triangle {
        Triangle::new(Grid::new(exponents), |place| self.source(place))
    }

    fn component_count(&self) -> usize {
        if self.source.channel.image.components < 3 { 1 } else { 3 }
    }

    fn codes(&self, value: DVec3) -> DVec3 {
        codes(value, self.source.channel.transfer)
    }

    /// Mean over places inside and components, codes squared.
    fn squared_error(&self, triangle: &Triangle) -> f64 {
        let Grid { n, m } = triangle.grid;
        let middle = |k: usize| (k as f64 + 1.0 / 3.0) / PLACES as f64;
        let places = (0..PLACES).flat_map(|j| (0..PLACES - j).map(move |i| [middle(i), middle(j)]));
        let (mut sum, mut count) = (0.0, 0.0);
        for place in places {
            let shown = triangle.shown([place[0] * n as f64, place[1] * m as f64]);
            let off = (self.codes(shown) - self.codes(self.source(place))).to_array();
            sum += off.iter().take(self.component_count()).map(|off| off * off).sum::<f64>();
            count += self.component_count() as f64;
        }
        sum / count
    }
}

fn codes(value: DVec3, transfer: Transfer) -> DVec3 {
    let inside = value.clamp(DVec3::ZERO, DVec3::ONE);
    match transfer {
        Transfer::Linear => inside * 255.0,
        Transfer::Srgb => inside.map(|value| 255.0 * f64::from(linear_to_srgb(value as f32))),
    }
}
