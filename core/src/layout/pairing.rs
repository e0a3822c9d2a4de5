//! Which triangles merge into quads: a maximal matching over the edges where merging costs nothing. It is
//! greedy, not the maximum by texels saved.

use crate::colors::Resolutions;
use crate::mesh::CanvasMesh;

/// For each face the face it merges with. `mergeable` says by canvas edge whether its two sides may become
/// one quad; edges that do not have exactly two different triangles of one exponent never do.
///
/// Karp and Sipser's rule: faces with one choice left are served first, then the lowest number, with its
/// partner of fewest choices. Linear in the number of edges.
pub fn pair_triangles(
    canvas: &CanvasMesh,
    resolutions: &Resolutions,
    mergeable: &[bool],
) -> Vec<Option<u32>> {
    let mut matching = Matching::new(canvas, resolutions, mergeable);
    for face in 0..canvas.faces.len() as u32 {
        matching.settle_forced();
        matching.settle(face);
    }
    matching.partner
}

struct Matching {
    /// Up to three possible partners of each face.
    choices: Vec<Vec<u32>>,
    open: Vec<u32>,
    partner: Vec<Option<u32>>,
    forced: Vec<u32>,
}

impl Matching {
    fn new(canvas: &CanvasMesh, resolutions: &Resolutions, mergeable: &[bool]) -> Self {
        let mut choices = vec![Vec::new(); canvas.faces.len()];
        for (edge, _) in canvas.edges.iter().zip(mergeable).filter(|(_, merge)| **merge) {
            let &[a, b] = canvas.sides(edge) else { continue };
            let fits = |face: u32| canvas.faces[face as usize].is_triangle();
            let [ra, rb] = [a, b].map(|side| resolutions.faces[side.face as usize]);
            if a.face != b.face && fits(a.face) && fits(b.face) && ra == rb {
                choices[a.face as usize].push(b.face);
                choices[b.face as usize].push(a.face);
            }
        }
        let open: Vec<u32> = choices.iter().map(|choices| choices.len() as u32).collect();
        // Popped from the end: low numbers first.
        let forced = (0..open.len() as u32).rev().filter(|&face| open[face as usize] == 1).collect();
        Self { partner: vec![None; choices.len()], choices, open, forced }
    }

    fn settle_forced(&mut self) {
        while let Some(face) = self.forced.pop() {
            self.settle(face);
        }
    }

    fn settle(&mut self, face: u32) {
        if self.partner[face as usize].is_some() {
            return;
        }
        let free = |other: &&u32| self.partner[**other as usize].is_none();
        let best =
            self.choices[face as usize].iter().filter(free).min_by_key(|other| self.open[**other as usize]);
        if let Some(&other) = best {
            self.partner[face as usize] = Some(other);
            self.partner[other as usize] = Some(face);
            for settled in [face, other] {
                for at in 0..self.choices[settled as usize].len() {
                    let neighbor = self.choices[settled as usize][at];
                    self.open[neighbor as usize] -= 1;
                    if self.open[neighbor as usize] == 1 && self.partner[neighbor as usize].is_none() {
                        self.forced.push(neighbor);
                    }
                }
            }
        }
    }
}
