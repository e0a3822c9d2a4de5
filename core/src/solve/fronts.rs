//! In which order an island's variables are eliminated, and which of them together.
//!
//! Variables that nearly the same later ones depend on form a front: a small dense matrix, so that the
//! factorization runs over dense columns (I. Duff and J. Reid, "The multifrontal solution of indefinite sparse
//! symmetric linear equations", ACM TOMS 9, 1983). The order is that of P. Amestoy, T. Davis and I. Duff, "An
//! approximate minimum degree ordering algorithm", SIAM J. Matrix Anal. Appl. 17, 1996, as `faer` has it.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

use super::island::Island;

/// So few variables are one front.
const DENSE_MAX: usize = 24;
/// Entries that are always zero, as a share of a front's columns, for which two fronts are still made one.
const PADDING: f64 = 0.2;
/// Entries of all columns beyond which memory is not asked for: 2 GiB.
const ENTRIES_MAX: usize = 1 << 28;
const NONE: u32 = u32::MAX;

/// Columns that are eliminated together, and the later rows that they reach.
pub struct Front {
    /// Position of the first column.
    pub first: usize,
    /// Number of columns.
    pub width: usize,
    /// Positions of the rows below the columns, ascending.
    pub rows: Vec<u32>,
    /// Where each of `rows` is in the parent: among its columns, then its rows.
    pub targets: Vec<u32>,
    /// Earlier fronts whose rows are added to this one, ascending.
    pub children: Vec<u32>,
    /// Entries of the columns that are zero.
    padding: usize,
}

impl Front {
    /// Rows and columns together.
    pub fn size(&self) -> usize {
        self.width + self.rows.len()
    }

    /// Where a position is in this front, which has it.
    pub fn local(&self, position: u32) -> u32 {
        match (position as usize).checked_sub(self.first) {
            Some(column) if column < self.width => column as u32,
            _ => (self.width + self.rows.partition_point(|&row| row < position)) as u32,
        }
    }
}

/// Children come before their parents, and the fronts below one follow each other without a gap.
pub struct Fronts {
    /// By variable: when it is eliminated.
    pub positions: Vec<u32>,
    pub fronts: Vec<Front>,
    /// By position.
    pub front_of: Vec<u32>,
}

impl Fronts {
    /// `None` where no memory is left.
    pub fn new(island: &Island) -> Option<Self> {
        let count = island.variables().len();
        if count <= DENSE_MAX {
            let fronts = if count > 0 { vec![Front::new(0, count, Vec::new())] } else { Vec::new() };
            return Some(Self { positions: (0..count as u32).collect(), fronts, front_of: vec![0; count] });
        }
        let neighbors = neighbors(island);
        let mut positions = minimum_degree(&neighbors)?;
        let parents = parents(&neighbors, &positions);
        let later = postorder(&parents);
        positions.iter_mut().for_each(|position| *position = later[*position as usize]);
        let mut fronts = eliminate(&neighbors, &positions);
        if fronts.iter().map(|front| front.width * front.size()).sum::<usize>() > ENTRIES_MAX {
            return None;
        }
        let mut front_of = vec![0; count];
        for (number, front) in fronts.iter().enumerate() {
            front_of[front.first..][..front.width].fill(number as u32);
        }
        for number in 0..fronts.len() {
            let Some(&row) = fronts[number].rows.first() else { continue };
            let parent = front_of[row as usize] as usize;
            fronts[number].targets =
                fronts[number].rows.iter().map(|&row| fronts[parent].local(row)).collect();
            fronts[parent].children.push(number as u32);
        }
        Some(Self { positions, fronts, front_of })
    }
}

impl Front {
    fn new(first: usize, width: usize, rows: Vec<u32>) -> Self {
        Self { first, width, rows, targets: Vec::new(), children: Vec::new(), padding: 0 }
    }
}

/// Variables that share a row, by variable, ascending.
fn neighbors(island: &Island) -> Vec<Vec<u32>> {
    let mut neighbors: Vec<Vec<u32>> = vec![Vec::new(); island.variables().len()];
    for cell in 0..island.cell_count() {
        let places = island.cell(cell);
        for &a in places {
            neighbors[a as usize].extend(places.iter().filter(|&&b| b != a));
        }
    }
    for list in &mut neighbors {
        list.sort_unstable();
        list.dedup();
    }
    neighbors
}

/// By variable its position.
fn minimum_degree(neighbors: &[Vec<u32>]) -> Option<Vec<u32>> {
    let count = neighbors.len();
    let mut starts = vec![0u32];
    let mut entries = Vec::new();
    for (column, list) in neighbors.iter().enumerate() {
        entries.extend(list.iter().filter(|&&row| (row as usize) < column));
        starts.push(entries.len() as u32);
    }
    let pattern = SymbolicSparseColMatRef::new_checked(count, count, &starts, None, &entries);
    let (mut order, mut positions) = (vec![0u32; count], vec![0u32; count]);
    let mut memory = MemBuffer::try_new(amd::order_scratch::<u32>(count, entries.len())).ok()?;
    let stack = MemStack::new(&mut memory);
    amd::order(&mut order, &mut positions, pattern, amd::Control::default(), stack).ok()?;
    Some(positions)
}

/// By position the first later one that depends on it, in the factor (J. Liu, "The role of elimination trees
/// in sparse factorization", SIAM J. Matrix Anal. Appl. 11, 1990).
fn parents(neighbors: &[Vec<u32>], positions: &[u32]) -> Vec<u32> {
    let mut order = vec![0u32; positions.len()];
    for (variable, &position) in positions.iter().enumerate() {
        order[position as usize] = variable as u32;
    }
    let mut parents = vec![NONE; positions.len()];
    let mut ancestors = vec![NONE; positions.len()];
    for (at, &variable) in order.iter().enumerate() {
        for &neighbor in &neighbors[variable as usize] {
            let mut below = positions[neighbor as usize];
            while below < at as u32 {
                let up = std::mem::replace(&mut ancestors[below as usize], at as u32);
                if up == NONE {
                    parents[below as usize] = at as u32;
                    break;
                }
                below = up;
            }
        }
    }
    parents
}

/// New positions by old ones: what hangs below one comes right before it.
fn postorder(parents: &[u32]) -> Vec<u32> {
    let mut first_child = vec![NONE; parents.len()];
    let mut next = vec![NONE; parents.len()];
    let mut stack = Vec::new();
    for at in (0..parents.len()).rev() {
        match parents[at] {
            NONE => stack.push(at as u32),
            parent => next[at] = std::mem::replace(&mut first_child[parent as usize], at as u32),
        }
    }
    let mut later = vec![0; parents.len()];
    let mut count = 0;
    while let Some(&at) = stack.last() {
        let child = std::mem::replace(&mut first_child[at as usize], NONE);
        if child == NONE {
            stack.pop();
            later[at as usize] = count;
            count += 1;
            continue;
        }
        // The siblings wait below the first one, in their order.
        let from = stack.len();
        let mut sibling = child;
        while sibling != NONE {
            stack.push(sibling);
            sibling = next[sibling as usize];
        }
        stack[from..].reverse();
    }
    later
}

/// The fronts of columns in order; a column joins the one before it where that leaves few zeros.
fn eliminate(neighbors: &[Vec<u32>], positions: &[u32]) -> Vec<Front> {
    let count = positions.len();
    let mut order = vec![0u32; count];
    for (variable, &position) in positions.iter().enumerate() {
        order[position as usize] = variable as u32;
    }
    let mut fronts: Vec<Front> = Vec::new();
    // By position: the fronts whose first row it is, as a list.
    let (mut waiting, mut next) = (vec![NONE; count], Vec::new());
    let mut seen = vec![NONE; count];
    for at in 0..count {
        let mut rows: Vec<u32> = Vec::new();
        let mut add = |row: u32| {
            if row > at as u32 && std::mem::replace(&mut seen[row as usize], at as u32) != at as u32 {
                rows.push(row);
            }
        };
        neighbors[order[at] as usize].iter().for_each(|&neighbor| add(positions[neighbor as usize]));
        let mut child = waiting[at];
        while child != NONE {
            fronts[child as usize].rows.iter().for_each(|&row| add(row));
            child = next[child as usize];
        }
        rows.sort_unstable();
        let joined = fronts.last_mut().filter(|last| last.rows.first() == Some(&(at as u32)));
        let joined = joined.is_some_and(|last| last.try_join(&rows));
        if joined {
            if let Some(last) = fronts.last_mut() {
                last.rows = rows;
            }
        } else {
            fronts.push(Front::new(at, 1, rows));
            next.push(NONE);
        }
        let number = fronts.len() - 1;
        if let Some(&row) = fronts[number].rows.first() {
            next[number] = std::mem::replace(&mut waiting[row as usize], number as u32);
        }
    }
    fronts
}

impl Front {
    /// Takes in the next column, below which are `rows`, unless that leaves too many zeros.
    fn try_join(&mut self, rows: &[u32]) -> bool {
        let width = self.width + 1;
        let padding = self.padding + self.width * (rows.len() + 1 - self.rows.len());
        let is_joined = padding as f64 <= PADDING * (width * (width + rows.len())) as f64;
        if is_joined {
            (self.width, self.padding) = (width, padding);
        }
        is_joined
    }
}
