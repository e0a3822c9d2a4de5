//! The texel rules that may leave the format's range, as rows for a solver: a texel component is
//! `constant + Σ weight · variable`.
//!
//! Rows that lean on the same few samples (the texels around one block, or one border texel) form a group, to
//! be dealt with at once. Copies are samples and need no row. Variables are samples (one component at a time), or for normals the
//! three components of each sample, since frames mix them.

use std::sync::OnceLock;

use crate::colors::Tap;
use crate::layout::Block;
use glam::Mat3;

use super::paint::{BeyondCell, Columns, corner_weights};
use super::{LevelChannel, corner_point, from_right_angle};

/// Rows in the order of blocks; terms of a row name each variable once, by its number in `variables`.
#[derive(Clone, Debug, Default)]
pub struct Rules {
    variables: Vec<u32>,
    first_term: Vec<u32>,
    terms: Vec<(u32, f64)>,
    constants: Vec<f32>,
    /// One past the last row of each group.
    group_ends: Vec<u32>,
    /// By group.
    faces: Vec<Option<u32>>,
    /// Whether the weights of every row sum to 1 and no row has a constant: all but normals.
    is_affine: bool,
    links: OnceLock<Links>,
}

/// Which groups of rules are about a variable.
#[derive(Clone, Debug)]
pub struct Links {
    /// By variable, one more at the end.
    first_group: Vec<u32>,
    groups: Vec<u32>,
}

impl Links {
    fn new(rules: &Rules) -> Self {
        let count = rules.variables.len();
        let each = |visit: &mut dyn FnMut(usize, u32)| {
            let mut last = vec![u32::MAX; count];
            for group in 0..rules.group_count() as u32 {
                let rows = rules.group(group as usize);
                for &(variable, _) in rows.flat_map(|row| rules.terms(row)) {
                    if std::mem::replace(&mut last[variable as usize], group) != group {
                        visit(variable as usize, group);
                    }
                }
            }
        };
        let mut first_group = vec![0; count + 1];
        each(&mut |variable, _| first_group[variable + 1] += 1);
        for variable in 0..count {
            first_group[variable + 1] += first_group[variable];
        }
        let mut filled = first_group.clone();
        let mut groups = vec![0; first_group[count] as usize];
        each(&mut |variable, group| {
            groups[filled[variable] as usize] = group;
            filled[variable] += 1;
        });
        Self { first_group, groups }
    }

    /// Ascending.
    pub fn groups(&self, variable: u32) -> &[u32] {
        let ends = &self.first_group[variable as usize..=variable as usize + 1];
        &self.groups[ends[0] as usize..ends[1] as usize]
    }
}

impl Rules {
    pub fn len(&self) -> usize {
        self.constants.len()
    }

    pub fn is_empty(&self) -> bool {
        self.constants.is_empty()
    }

    /// Rules given row by row, each a group of its own, for tests of what deals with rules.
    #[cfg(test)]
    pub fn from_rows(rows: &[(&[(u32, f64)], f32)]) -> Self {
        let is_one = |terms: &[(u32, f64)]| (terms.iter().map(|t| t.1).sum::<f64>() - 1.0).abs() < 1e-9;
        let is_affine = rows.iter().all(|(terms, constant)| *constant == 0.0 && is_one(terms));
        let mut rules = Self { is_affine, ..Self::default() };
        for (terms, constant) in rows {
            rules.push(terms, *constant);
            rules.end_group(None);
        }
        rules.number_variables();
        rules
    }

    /// What the terms are about, ascending: samples, or `3 * sample + component` of normals.
    pub fn variables(&self) -> &[u32] {
        &self.variables
    }

    pub fn group_count(&self) -> usize {
        self.group_ends.len()
    }

    /// The rows of a group.
    pub fn group(&self, group: usize) -> std::ops::Range<usize> {
        let first = if group == 0 { 0 } else { self.group_ends[group - 1] };
        first as usize..self.group_ends[group] as usize
    }

    /// Rules of blocks beyond vertex colors, four rows to a group, whose weights sum to 1; for the same.
    #[cfg(test)]
    pub fn from_cells(rows: &[(Vec<(u32, f64)>, f32)]) -> Self {
        let mut rules = Self { is_affine: true, ..Self::default() };
        for (face, rows) in rows.chunks(4).enumerate() {
            rows.iter().for_each(|(terms, constant)| rules.push(terms, *constant));
            rules.end_group(Some(face as u32));
        }
        rules.number_variables();
        rules
    }

    /// The face whose corners alone the group is about, beyond vertex colors; none for border texels and for
    /// columns, which other samples have a part in.
    pub fn face(&self, group: usize) -> Option<usize> {
        self.faces[group].map(|face| face as usize)
    }

    /// Which groups are about which variable; found when first asked for.
    pub fn links(&self) -> &Links {
        self.links.get_or_init(|| Links::new(self))
    }

    /// Whether every row is a mean of samples, its weights summing to 1.
    pub fn is_affine(&self) -> bool {
        self.is_affine
    }

    /// What the texel component of a row is, by values of the variables; where weights sum to 1, by
    /// differences to the first, so that large weights of opposite signs multiply what is small.
    pub fn value(&self, row: usize, values: &[f64]) -> f64 {
        let terms = self.terms(row);
        match terms.split_first() {
            Some((first, rest)) if self.is_affine => {
                let base = values[first.0 as usize];
                let change = |&(v, weight): &(u32, f64)| (values[v as usize] - base) * weight;
                base + rest.iter().map(change).sum::<f64>()
            }
            _ => {
                let sum: f64 = terms.iter().map(|&(v, weight)| values[v as usize] * weight).sum();
                sum + f64::from(self.constants[row])
            }
        }
    }

    fn end_group(&mut self, face: Option<u32>) {
        self.faces.push(face);
        self.group_ends.push(self.constants.len() as u32);
    }

    pub fn constant(&self, row: usize) -> f32 {
        self.constants[row]
    }

    /// `(number of the variable, weight)` of a row.
    pub fn terms(&self, row: usize) -> &[(u32, f64)] {
        &self.terms[self.first_term[row] as usize..self.first_term[row + 1] as usize]
    }

    /// From here on terms name variables by their place among those that occur.
    fn number_variables(&mut self) {
        let count = self.terms.iter().map(|term| term.0 as usize + 1).max().unwrap_or(0);
        let mut numbers = vec![0; count];
        self.terms.iter().for_each(|term| numbers[term.0 as usize] = 1);
        for (variable, number) in numbers.iter_mut().enumerate() {
            if *number == 1 {
                *number = self.variables.len() as u32;
                self.variables.push(variable as u32);
            }
        }
        self.terms.iter_mut().for_each(|term| term.0 = numbers[term.0 as usize]);
    }

    fn push(&mut self, terms: &[(u32, f64)], constant: f32) {
        if self.first_term.is_empty() {
            self.first_term.push(0);
        }
        let first = self.terms.len();
        for &(variable, weight) in terms {
            match self.terms[first..].iter_mut().find(|(known, _)| *known == variable) {
                Some((_, sum)) => *sum += weight,
                None => self.terms.push((variable, weight)),
            }
        }
        self.first_term.push(self.terms.len() as u32);
        self.constants.push(constant);
    }
}

/// The rows of one level.
pub fn rules(channel: &LevelChannel<'_>) -> Rules {
    let rules = Rules { is_affine: channel.frames.is_none(), ..Rules::default() };
    let mut builder = Builder { channel, rules };
    for block in &channel.layout.blocks {
        if channel.layout.is_beyond_across(block, channel.numbering.level) {
            block.kind.faces().for_each(|face| builder.columns(block, face));
        } else if channel.layout.is_beyond(block, channel.numbering.level) {
            block.kind.faces().for_each(|face| builder.beyond(block, face));
        } else if block.kind.is_lone() {
            block.kind.faces().for_each(|face| builder.border(face));
        }
    }
    builder.rules.number_variables();
    builder.rules
}

/// A weighted sample as a face stores it.
struct Part {
    sample: u32,
    weight: f64,
    face: usize,
    at: (f32, f32),
}

struct Builder<'a> {
    channel: &'a LevelChannel<'a>,
    rules: Rules,
}

impl Builder<'_> {
    /// MCT equation 1 along the diagonal; nothing has to match on an edge that nobody shares.
    fn border(&mut self, face: usize) {
        let (right, diagonal) = self.channel.right_angle(face);
        if self.channel.is_free(face, diagonal) {
            return;
        }
        let [n, _] = self.channel.numbering.shape(face).segments;
        for x in 1..=n {
            let y = n + 1 - x;
            let mut parts = Vec::with_capacity(6);
            for (x, y, weight) in [(x, y - 1, 1.0), (x - 1, y, 1.0), (x - 1, y - 1, -1.0)] {
                let (i, j) = from_right_angle(right, n, x, y);
                self.add_point(&mut parts, face, (i, j), weight);
            }
            self.push(&parts);
            self.rules.end_group(None);
        }
    }

    /// A weighted grid point of a face.
    fn add_point(&self, parts: &mut Vec<Part>, face: usize, (i, j): (u32, u32), weight: f64) {
        let numbering = self.channel.numbering;
        let Tap { samples, second } = numbering.tap(face, i, j);
        let [s, t] = numbering.shape(face).unit(i, j);
        let mut add = |sample, weight| parts.push(Part { sample, weight, face, at: (s, t) });
        if second != 0.0 {
            add(samples[1], weight * f64::from(second));
        }
        add(samples[0], weight * f64::from(1.0 - second));
    }

    /// The columns of a block that is beyond vertex colors along its short side alone: two texels each, a group.
    fn columns(&mut self, block: &Block, face: usize) {
        let columns = Columns::new(self.channel, block, face);
        for column in 0..columns.columns_rows[0] {
            for dy in 0..2 {
                let mut parts = Vec::with_capacity(4);
                for (point, weight) in columns.points(column).into_iter().zip(columns.weights(dy)) {
                    self.add_point(&mut parts, face, point, weight);
                }
                self.push(&parts);
            }
            self.rules.end_group(None);
        }
    }

    /// The texels whose bilinear footprint a face is.
    fn beyond(&mut self, block: &Block, face: usize) {
        let numbering = self.channel.numbering;
        let corners = self.channel.square(face);
        let cell = BeyondCell::new(self.channel, block, face);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weights = corner_weights(corners.map(|row| row.map(|c| c.is_some())), cell.at(dx, dy));
            let parts = weights.into_iter().filter_map(|([x, y], weight)| {
                let corner = corners[y][x]?;
                let sample = numbering.topology.fan_of[face][corner];
                let at = corner_point(numbering.canvas.faces[face].is_triangle(), corner);
                Some(Part { sample, weight, face, at })
            });
            let parts: Vec<Part> = parts.collect();
            self.push(&parts);
        }
        self.rules.end_group(Some(face as u32));
    }

    fn push(&mut self, parts: &[Part]) {
        let Some(frames) = self.channel.frames else {
            let terms: Vec<_> = parts.iter().map(|part| (part.sample, part.weight)).collect();
            self.rules.push(&terms, 0.0);
            return;
        };
        let maps: Vec<Mat3> = (parts.iter())
            .map(|part| frames.to_stored(self.channel.numbering.canvas, part.face, part.at.0, part.at.1))
            .collect();
        for component in 0..3 {
            let terms: Vec<_> = (parts.iter().zip(&maps))
                .flat_map(|(part, map)| {
                    let row = map.row(component);
                    (0u32..3).map(move |k| (part.sample * 3 + k, part.weight * f64::from(row[k as usize])))
                })
                .collect();
            // Stored values are 1/2 plus the mapped normal, and the weights of a rule sum to 1.
            self.rules.push(&terms, 0.5);
        }
    }
}
