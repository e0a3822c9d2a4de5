//! One implicit step of an exchange between samples: `(M + W) C' = M C`, `M` the masses and `W` the graph
//! Laplacian of what they exchange.

use faer::Mat;
use faer::linalg::solvers::Solve;
use faer::sparse::Pair;
use glam::DVec4;

use crate::math::cholesky::Pattern;
use crate::math::partition::Partition;

/// What two samples exchange, the lower number first: above zero.
pub(super) struct Bond {
    pub ends: [u32; 2],
    pub conductance: f64,
}

/// A sample's mass is at least this share of all it exchanges: less is lost in rounding, and beyond a
/// thousand million to one nothing is left to even out.
const MASS_SHARE: f64 = 1e-10;
/// Samples that differ by less than this, relative to their values, have nothing to exchange.
const FLAT: f64 = 1e-6;

/// Who exchanges with whom, kept from exchange to exchange: from where all faces are at vertex colors on it is
/// the same at every level.
#[derive(Default)]
pub(super) struct Network {
    /// Entries below the diagonal and on it, and their pattern.
    known: Option<(Vec<Pair<u32, u32>>, Pattern)>,
}

impl Network {
    /// The pattern of the entries; that of before where they are the same.
    fn pattern(&mut self, size: usize, entries: Vec<Pair<u32, u32>>) -> Option<&Pattern> {
        if self.known.as_ref().is_none_or(|(known, _)| *known != entries) {
            let pattern = Pattern::new(size, &entries)?;
            self.known = Some((entries, pattern));
        }
        self.known.as_ref().map(|(_, pattern)| pattern)
    }
}

/// Replaces `values` by those after the exchange, in `step_count` equal steps. No value leaves the range of
/// its island, and the sum of mass times value stays. `None` where the system cannot be factored.
pub(super) fn exchange(
    network: &mut Network,
    bonds: &[Bond],
    masses: &[f64],
    step_count: usize,
    values: &mut [DVec4],
) -> Option<()> {
    let islands = Islands::new(bonds, values);
    let size = islands.members.len();
    if size == 0 {
        return Some(());
    }
    let links = islands.links(bonds, step_count);
    let mut exchanged = vec![0.0; size];
    for link in &links {
        link.ends.iter().for_each(|&end| exchanged[end as usize] += link.conductance);
    }
    let diagonal = islands.members.iter().zip(&exchanged).map(|(&member, sum)| {
        let mass = masses[member as usize].max(MASS_SHARE * sum);
        mass + sum
    });
    let values_of_entries: Vec<f64> = links.iter().map(|link| -link.conductance).chain(diagonal).collect();
    let below = links.iter().map(|link| Pair { row: link.ends[1], col: link.ends[0] });
    let entries = below.chain((0..size as u32).map(|at| Pair { row: at, col: at })).collect();
    let factor = network.pattern(size, entries)?.factor(&values_of_entries)?;
    let columns = islands.components();
    for _ in 0..step_count {
        // For the change alone: what is even stays so to the last bit.
        let mut gains = vec![DVec4::ZERO; size];
        for link in &links {
            let [from, to] = link.ends.map(|end| values[islands.members[end as usize] as usize]);
            let gain = (to - from) * link.conductance;
            gains[link.ends[0] as usize] += gain;
            gains[link.ends[1] as usize] -= gain;
        }
        let right = Mat::from_fn(size, columns.len(), |row, column| gains[row][columns[column]]);
        let solved = factor.solve(&right);
        let change = (0..size).map(|row| {
            let mut change = DVec4::ZERO;
            columns.iter().enumerate().for_each(|(from, &column)| change[column] = solved[(row, from)]);
            change
        });
        islands.apply(&change.collect::<Vec<_>>(), masses, values);
    }
    Some(())
}

/// Sets of samples that bonds connect, those of one value left out.
struct Islands {
    /// Samples, by number.
    members: Vec<u32>,
    /// The island of each of them.
    island_of: Vec<u32>,
    low: Vec<DVec4>,
    high: Vec<DVec4>,
}

impl Islands {
    fn new(bonds: &[Bond], values: &[DVec4]) -> Self {
        let mut partition = Partition::new(values.len());
        bonds.iter().for_each(|bond| partition.join(bond.ends[0], bond.ends[1]));
        let roots: Vec<u32> = (0..values.len() as u32).map(|sample| partition.root(sample)).collect();
        let mut low = values.to_vec();
        let mut high = values.to_vec();
        for (&root, &value) in roots.iter().zip(values) {
            low[root as usize] = low[root as usize].min(value);
            high[root as usize] = high[root as usize].max(value);
        }
        let is_flat = |root: u32| {
            let (low, high) = (low[root as usize], high[root as usize]);
            let size = low.abs().max(high.abs());
            (high - low).cmple(size * FLAT).all()
        };
        let members: Vec<u32> = (0..values.len() as u32).filter(|&k| !is_flat(roots[k as usize])).collect();
        let island_of = members.iter().map(|&member| roots[member as usize]).collect();
        Self { members, island_of, low, high }
    }

    /// The bonds between members, by their numbers among them, for one step of several.
    fn links(&self, bonds: &[Bond], step_count: usize) -> Vec<Bond> {
        let mut local = vec![u32::MAX; self.low.len()];
        self.members.iter().zip(0u32..).for_each(|(&member, number)| local[member as usize] = number);
        let link = |bond: &Bond| {
            let ends = bond.ends.map(|end| local[end as usize]);
            let conductance = bond.conductance / step_count as f64;
            (ends[0] != u32::MAX).then_some(Bond { ends, conductance })
        };
        bonds.iter().filter_map(link).collect()
    }

    /// The components that differ anywhere.
    fn components(&self) -> Vec<usize> {
        let differs = |k: &usize| {
            self.island_of
                .iter()
                .any(|&island| self.low[island as usize][*k] < self.high[island as usize][*k])
        };
        (0..4).filter(differs).collect()
    }

    /// Adds the change, less what rounding adds to or takes from an island as a whole.
    fn apply(&self, change: &[DVec4], masses: &[f64], values: &mut [DVec4]) {
        let mut sums = vec![(DVec4::ZERO, 0.0); values.len()];
        let members = || self.members.iter().zip(&self.island_of).zip(change);
        for ((&member, &island), change) in members() {
            let (sum, mass) = &mut sums[island as usize];
            *sum += *change * masses[member as usize];
            *mass += masses[member as usize];
        }
        for ((&member, &island), change) in members() {
            let (sum, mass) = sums[island as usize];
            let island = island as usize;
            let value = &mut values[member as usize];
            *value = (*value + *change - sum / mass).clamp(self.low[island], self.high[island]);
        }
    }
}
