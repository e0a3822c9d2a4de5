//! Polygons to triangles by clipping ears in the plane that fits them best.
//!
//! The plane is Newell's: its normal's components are the areas of the polygon's three projections. An
//! ear is a corner whose triangle turns the polygon's way and holds none of the corners that turn the
//! other way. Work is bounded by a multiple of the corner count, so hostile polygons cost linear time.

use glam::{DVec2, DVec3};

/// Point-in-triangle tests allowed for each corner: enough for any polygon of a thousand corners.
const TESTS_PER_CORNER: u64 = 1024;

/// And at most so many for one polygon, which is less than a second's work.
const TESTS_MAX: u64 = 1 << 28;

/// Triangles of the polygon as corner numbers, `points.len() - 2` of them, turning as the polygon does.
pub struct Cut {
    pub triangles: Vec<[usize; 3]>,
    /// Whether every triangle was an ear. A polygon that crosses itself, has no area or takes too much
    /// work ends in a fan.
    pub simple: bool,
}

/// `points.len() >= 3`.
pub fn cut(points: &[DVec3]) -> Cut {
    match flatten(points) {
        Some(flat) => Clipper::new(flat).run(),
        None => Cut { triangles: (2..points.len()).map(|i| [0, i - 1, i]).collect(), simple: false },
    }
}

/// Coordinates in the best-fit plane, in which the polygon turns counterclockwise. `None` without area.
fn flatten(points: &[DVec3]) -> Option<Vec<DVec2>> {
    let origin = points[0];
    let next = |i: usize| points[(i + 1) % points.len()] - origin;
    let normal: DVec3 = (0..points.len()).map(|i| (points[i] - origin).cross(next(i))).sum();
    let normal = normal.try_normalize()?;
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    Some(points.iter().map(|&point| DVec2::new((point - origin).dot(x), (point - origin).dot(y))).collect())
}

/// Twice the signed area of a triangle.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

struct Clipper {
    points: Vec<DVec2>,
    previous: Vec<usize>,
    next: Vec<usize>,
    /// Corners that do not turn the polygon's way, and where each stands in this list.
    reflex: Vec<usize>,
    reflex_place: Vec<Option<usize>>,
    tests_left: u64,
    triangles: Vec<[usize; 3]>,
}

impl Clipper {
    fn new(points: Vec<DVec2>) -> Self {
        let count = points.len();
        let mut clipper = Self {
            previous: (0..count).map(|i| (i + count - 1) % count).collect(),
            next: (0..count).map(|i| (i + 1) % count).collect(),
            reflex: Vec::new(),
            reflex_place: vec![None; count],
            tests_left: (TESTS_PER_CORNER * count as u64).min(TESTS_MAX),
            triangles: Vec::with_capacity(count - 2),
            points,
        };
        for corner in 0..count {
            clipper.classify(corner);
        }
        clipper
    }

    fn corner_turn(&self, corner: usize) -> f64 {
        let at = |corner: usize| self.points[corner];
        turn(at(self.previous[corner]), at(corner), at(self.next[corner]))
    }

    fn classify(&mut self, corner: usize) {
        let reflex = self.corner_turn(corner) <= 0.0;
        match (reflex, self.reflex_place[corner]) {
            (true, None) => {
                self.reflex_place[corner] = Some(self.reflex.len());
                self.reflex.push(corner);
            }
            (false, Some(_)) => self.forget(corner),
            _ => {}
        }
    }

    fn forget(&mut self, corner: usize) {
        if let Some(place) = self.reflex_place[corner].take() {
            self.reflex.swap_remove(place);
            if let Some(&moved) = self.reflex.get(place) {
                self.reflex_place[moved] = Some(place);
            }
        }
    }

    fn run(mut self) -> Cut {
        let mut corner = 0;
        let mut left = self.points.len();
        let mut missed = 0;
        while left > 3 && self.tests_left > 0 {
            if self.is_ear(corner) {
                // Skipping one corner spreads the cuts and keeps triangles from getting thin.
                corner = self.clip(corner);
                (left, missed) = (left - 1, 0);
            } else {
                corner = self.next[corner];
                missed += 1;
                if missed > left {
                    break;
                }
            }
        }
        let simple = left == 3;
        while left >= 3 {
            let (before, after) = (self.previous[corner], self.next[corner]);
            self.triangles.push([before, corner, after]);
            self.next[before] = after;
            self.previous[after] = before;
            corner = after;
            left -= 1;
        }
        Cut { triangles: self.triangles, simple }
    }

    /// Cuts off a corner; returns the corner to go on with.
    fn clip(&mut self, corner: usize) -> usize {
        let (before, after) = (self.previous[corner], self.next[corner]);
        self.triangles.push([before, corner, after]);
        self.next[before] = after;
        self.previous[after] = before;
        self.forget(corner);
        self.classify(before);
        self.classify(after);
        self.next[after]
    }

    fn is_ear(&mut self, corner: usize) -> bool {
        if self.reflex_place[corner].is_some() {
            return false;
        }
        let ear = [self.previous[corner], corner, self.next[corner]];
        let [a, b, c] = ear.map(|corner| self.points[corner]);
        for (tested, &other) in self.reflex.iter().enumerate() {
            let point = self.points[other];
            let shared = ear.contains(&other) || point == a || point == b || point == c;
            if !shared && turn(a, b, point) >= 0.0 && turn(b, c, point) >= 0.0 && turn(c, a, point) >= 0.0 {
                self.tests_left = self.tests_left.saturating_sub(tested as u64 + 1);
                return false;
            }
        }
        self.tests_left = self.tests_left.saturating_sub(self.reflex.len() as u64);
        true
    }
}

#[cfg(test)]
mod tests;
