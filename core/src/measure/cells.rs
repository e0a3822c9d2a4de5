//! The whole surface in nested cells: triangles cut into four again and again, and above them ever larger
//! groups of neighboring triangles. A sum over a wide part of the surface takes few cells where it varies
//! slowly, and misses no place of it.
//!
//! Cells stand in preorder, each with the number of the first that is not inside it, so a walk needs no
//! stack. How far it has to go down is decided as in Barnes and Hut, "A hierarchical O(N log N)
//! force-calculation algorithm", Nature 324, 1986: by a cell's size beside what the sum varies over.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::graph::Graph;

/// Cells that do not fit closer than this, in σ, are opened. Their second moments, which taking a whole
/// cell at its center leaves out, are then about 1 % of the Gaussian's.
const OPENED_AT: f64 = 0.5;

/// Cuts of one triangle, at most: 4^10 cells.
const DEPTH_MOST: u32 = 10;

/// A piece of the surface.
struct Cell {
    /// The area's center, mesh space.
    center: DVec3,
    /// No point of the cell is further from its center.
    radius: f64,
    /// Its share of the whole surface's area.
    share: f32,
    /// The cell after this one and all inside it.
    next: u32,
    /// A cone that holds all normals: its axis, unit length, and the sine of its half angle; 1 and more
    /// for any direction.
    axis: Vec3,
    sine: f32,
}

/// One triangle of those that are cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Its number in the graph.
    pub triangle: u32,
    /// It has `4^depth` innermost cells.
    pub depth: u32,
    /// Of an innermost cell, as [`Cells::new`] takes them.
    pub weight: f32,
    /// Of an innermost cell, a share of the whole surface's.
    pub share: f32,
}

/// Where a sum over the surface has its middle, and how far it reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gauss {
    /// Mesh space.
    pub center: DVec3,
    /// σ, mesh space.
    pub deviation: f64,
}

/// Where the Gaussian ends, in σ, and the share of its variance in the plane that is left.
pub const REACH: f64 = 3.0;
pub const VARIANCE_LEFT: f64 = 0.9494;

impl Gauss {
    /// 1 in the middle, 0 beyond the reach.
    pub fn at(&self, offset: DVec3) -> f64 {
        let squared = offset.length_squared() / self.deviation.powi(2);
        if squared > REACH * REACH { 0.0 } else { (-0.5 * squared).exp() }
    }
}

/// Who may take part in a sum over all cells.
#[derive(Clone, Copy, Debug)]
pub struct Admitted<'a> {
    /// Triangles count that face the side of this normal, unit length.
    pub normal: Vec3,
    /// The component whose triangles count, and the components in each cell, least and greatest.
    pub component: u32,
    pub components: &'a [[u32; 2]],
}

impl Cut {
    /// Of the innermost cells.
    pub fn cell_count(&self) -> usize {
        4usize.pow(self.depth)
    }
}

pub struct Cells {
    cells: Vec<Cell>,
    cuts: Vec<Cut>,
    /// By triangle of the graph, its first cell; `u32::MAX` where it has no area.
    firsts: Vec<u32>,
}

impl Cells {
    /// `weights` say how finely each triangle of the graph is cut: an innermost cell weighs about 1, or less
    /// where a whole triangle does.
    pub fn new(graph: &Graph, weights: &[f64]) -> Self {
        let areas = || (0..graph.corners.len() as u32).map(|triangle| 0.5 * graph.cross(triangle).length());
        let total: f64 = areas().filter(|area| area.is_finite()).sum();
        let cuts = areas().zip(weights).enumerate().filter_map(|(triangle, (area, &weight))| {
            let share = area / total;
            let depth = (0.5 * weight.log2()).round().clamp(0.0, f64::from(DEPTH_MOST)) as u32;
            let part = |whole: f64| (whole / f64::from(4u32.pow(depth))) as f32;
            (share > 0.0 && share.is_finite()).then(|| Cut {
                triangle: triangle as u32,
                depth,
                weight: part(weight),
                share: part(share),
            })
        });
        let mut cuts: Vec<Cut> = cuts.collect();
        sort_by_place(&mut cuts, graph);
        let cell_count: usize = cuts.iter().map(|cut| 1 + cut.cell_count() * 4 / 3).sum();
        let mut cells =
            Self { cells: Vec::with_capacity(cell_count), cuts, firsts: vec![u32::MAX; graph.corners.len()] };
        let count = cells.cuts.len();
        cells.add_group(graph, 0..count);
        cells
    }

    /// The triangles in the order of their cells.
    pub fn cuts(&self) -> &[Cut] {
        &self.cuts
    }

    /// That of a triangle's innermost cells, mesh space; infinite where there is none.
    pub fn radius(&self, triangle: u32) -> f64 {
        let mut at = self.firsts[triangle as usize] as usize;
        let Some(mut cell) = self.cells.get(at) else { return f64::INFINITY };
        while cell.next as usize > at + 1 {
            at += 1;
            cell = &self.cells[at];
        }
        cell.radius
    }

    /// What every cell holds, from what the innermost ones do, in the order of [`Cells::cuts`] and
    /// [`corners`].
    pub fn gathered<T: Clone>(&self, mut innermost: Vec<T>, join: impl Fn(&mut T, &T)) -> Vec<T> {
        let Some(first) = innermost.first().cloned() else { return Vec::new() };
        let mut held = vec![first; self.cells.len()];
        for (at, cell) in self.cells.iter().enumerate().rev() {
            let end = cell.next as usize;
            if end == at + 1 {
                if let Some(own) = innermost.pop() {
                    held[at] = own;
                }
                continue;
            }
            let mut sum = held[at + 1].clone();
            let mut child = self.cells[at + 1].next as usize;
            while child < end {
                join(&mut sum, &held[child]);
                child = self.cells[child].next as usize;
            }
            held[at] = sum;
        }
        held
    }

    /// The least and the greatest component among the triangles of every cell, and by the same numbering
    /// the components of the graph's triangles.
    pub fn components(&self, by_triangle: &mut [u32]) -> Vec<[u32; 2]> {
        // Numbered as they come, so that a run of triangles has a narrow range.
        let mut numbers = vec![u32::MAX; by_triangle.len()];
        let mut count = 0;
        for cut in &self.cuts {
            let number = &mut numbers[by_triangle[cut.triangle as usize] as usize];
            if *number == u32::MAX {
                *number = count;
                count += 1;
            }
        }
        by_triangle.iter_mut().for_each(|component| *component = numbers[*component as usize]);
        let innermost = self.cuts.iter().flat_map(|cut| {
            let own = by_triangle[cut.triangle as usize];
            std::iter::repeat_n([own; 2], cut.cell_count())
        });
        self.gathered(innermost.collect(), |sum, other| *sum = [sum[0].min(other[0]), sum[1].max(other[1])])
    }

    /// Gives the cells of one triangle within reach with what the Gaussian is there.
    pub fn of_triangle(&self, triangle: u32, gauss: &Gauss, mut add: impl FnMut(usize, f32)) {
        let first = self.firsts[triangle as usize] as usize;
        let Some(cell) = self.cells.get(first) else { return };
        self.walk(first..cell.next as usize, gauss, |_| Part::Whole, &mut add);
    }

    /// The same for all cells of those that are admitted.
    pub fn of_all(&self, gauss: &Gauss, admitted: &Admitted<'_>, mut add: impl FnMut(usize, f32)) {
        let part = |at: usize| {
            let [low, high] = admitted.components[at];
            if !(low..=high).contains(&admitted.component) {
                return Part::Nothing;
            }
            let cell = &self.cells[at];
            let facing = cell.axis.dot(admitted.normal);
            if facing <= -cell.sine {
                Part::Nothing
            } else if facing > cell.sine && low == high {
                Part::Whole
            } else {
                Part::Some
            }
        };
        self.walk(0..self.cells.len(), gauss, part, &mut add);
    }

    fn walk(
        &self,
        range: Range<usize>,
        gauss: &Gauss,
        part: impl Fn(usize) -> Part,
        add: &mut impl FnMut(usize, f32),
    ) {
        let (reach, largest) = (REACH * gauss.deviation, OPENED_AT * gauss.deviation);
        let mut at = range.start;
        while at < range.end {
            let cell = &self.cells[at];
            let next = cell.next as usize;
            let offset = cell.center - gauss.center;
            let is_near = offset.length_squared() <= (reach + cell.radius).powi(2);
            let part = if is_near { part(at) } else { Part::Nothing };
            let is_innermost = next == at + 1;
            if part == Part::Some && !is_innermost
                || part == Part::Whole && cell.radius > largest && !is_innermost
            {
                at += 1;
                continue;
            }
            if part == Part::Whole {
                let value = gauss.at(offset);
                if value > 0.0 {
                    add(at, value as f32);
                }
            }
            at = next;
        }
    }

    /// Adds the cell of a run of triangles, and all inside it.
    fn add_group(&mut self, graph: &Graph, range: Range<usize>) {
        match range.len() {
            0 => {}
            1 => {
                let cut = self.cuts[range.start];
                self.firsts[cut.triangle as usize] = self.cells.len() as u32;
                let axis = graph.cross(cut.triangle).normalize_or_zero().as_vec3();
                self.add_triangle(graph.corners[cut.triangle as usize], axis, &cut, cut.depth);
            }
            _ => {
                let at = self.cells.len();
                self.cells.push(Cell::EMPTY);
                let middle = range.start.midpoint(range.end);
                self.add_group(graph, range.start..middle);
                let second = self.cells.len();
                self.add_group(graph, middle..range.end);
                let next = self.cells.len() as u32;
                self.cells[at] = Cell { next, ..self.cells[at + 1].joined(&self.cells[second]) };
            }
        }
    }

    fn add_triangle(&mut self, corners: [DVec3; 3], axis: Vec3, cut: &Cut, depth: u32) {
        let at = self.cells.len();
        let center = (corners[0] + corners[1] + corners[2]) / 3.0;
        let radius = corners.iter().map(|corner| corner.distance(center)).fold(0.0, f64::max);
        let share = cut.share * 4f32.powi(depth as i32);
        self.cells.push(Cell { center, radius, share, next: 0, axis, sine: 0.0 });
        if depth > 0 {
            let middle = |i: usize, j: usize| corners[i].midpoint(corners[j]);
            for quarter in quarters(corners, [middle(1, 2), middle(2, 0), middle(0, 1)]) {
                self.add_triangle(quarter, axis, cut, depth - 1);
            }
        }
        self.cells[at].next = self.cells.len() as u32;
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Part {
    Nothing,
    Some,
    Whole,
}

impl Cell {
    const EMPTY: Self =
        Self { center: DVec3::ZERO, radius: 0.0, share: 0.0, next: 0, axis: Vec3::ZERO, sine: 0.0 };

    fn joined(&self, other: &Self) -> Self {
        let share = self.share + other.share;
        let toward_other = f64::from(other.share / share.max(f32::MIN_POSITIVE));
        let center = self.center.lerp(other.center, toward_other);
        let radius = [self, other].map(|cell| cell.center.distance(center) + cell.radius);
        let axis = (self.axis * self.share + other.axis * other.share).normalize_or_zero();
        let angle = [self, other].map(|cell| {
            let own = if cell.sine < 1.0 { cell.sine.asin() } else { std::f32::consts::FRAC_PI_2 };
            cell.axis.dot(axis).clamp(-1.0, 1.0).acos() + own
        });
        let angle = angle[0].max(angle[1]);
        // More than any cosine: such a cell is neither all on one side nor all on the other.
        let sine = if angle < std::f32::consts::FRAC_PI_2 { angle.sin() } else { 2.0 };
        Self { center, radius: radius[0].max(radius[1]), share, next: 0, axis, sine }
    }
}

/// The four triangles that a triangle is cut into, from its corners and the middles of the sides opposite.
fn quarters<T: Copy>([a, b, c]: [T; 3], [of_a, of_b, of_c]: [T; 3]) -> [[T; 3]; 4] {
    [[a, of_c, of_b], [of_c, b, of_a], [of_b, of_a, c], [of_a, of_b, of_c]]
}

/// The corners of the innermost cells of a triangle, as barycentrics, in order.
pub fn corners(depth: u32) -> Vec<[Vec3; 3]> {
    let mut cells = vec![[Vec3::X, Vec3::Y, Vec3::Z]];
    for _ in 0..depth {
        let cut = |corners: &[Vec3; 3]| {
            let middle = |i: usize, j: usize| corners[i].midpoint(corners[j]);
            quarters(*corners, [middle(1, 2), middle(2, 0), middle(0, 1)])
        };
        cells = cells.iter().flat_map(cut).collect();
    }
    cells
}

/// Puts neighbors side by side: by the octant of the normal, and there along a Z-order curve.
fn sort_by_place(cuts: &mut [Cut], graph: &Graph) {
    let center = |cut: &Cut| {
        let [a, b, c] = graph.corners[cut.triangle as usize];
        (a + b + c) / 3.0
    };
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for cut in cuts.iter() {
        (low, high) = (low.min(center(cut)), high.max(center(cut)));
    }
    let steps = f64::from((1u32 << AXIS_BITS) - 1);
    let scale = steps / (high - low).max_element().max(f64::MIN_POSITIVE);
    cuts.sort_by_cached_key(|cut| {
        let octant = graph.cross(cut.triangle).to_array().map(|along| u64::from(along < 0.0));
        let place = ((center(cut) - low) * scale).to_array().map(|along| spread(along as u64));
        let code = place[0] | place[1] << 1 | place[2] << 2;
        (octant[0] | octant[1] << 1 | octant[2] << 2, code, cut.triangle)
    });
}

const AXIS_BITS: u32 = 20;

/// Two zeros after each of the bits.
fn spread(bits: u64) -> u64 {
    (0..AXIS_BITS).map(|bit| (bits >> bit & 1) << (3 * bit)).sum()
}

#[cfg(test)]
mod tests;
