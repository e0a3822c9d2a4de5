//! Statistics of jumps along edges. Percentiles come from a histogram;
//! means are summed in the order of the edges in chunks whose bounds depend on the edges' number alone:
//! the same figures with any number of threads.

use rayon::prelude::*;

use super::edges::EdgePair;
use super::histogram::Histogram;
use super::report::Figures;

/// Points inside an edge, at (k + 1/2) / 17: no power of two divides 17, so they fall between texel
/// centers at every resolution.
pub const INTERIOR: usize = 17;

/// The interior points and the two ends.
pub const SAMPLES: usize = INTERIOR + 2;

/// Where an edge is judged that stays inside one cell of texels on both sides. Along a line through one cell
/// filtering is a quadratic: so is the difference of two, and between these positions hides at most an
/// eighth of its largest value. They are the ends and the midpoints of three pieces. They only sift: an edge
/// that shows [`FEW_LIMIT`] there is judged at all positions, so the guarantee's figures do not hang on them.
pub const FEW_POSITIONS: [f32; FEW] = [0.0, 3.0 / 17.0, 0.5, 14.0 / 17.0, 1.0];

/// How many of the [`SAMPLES`] each stands for: the pieces are 6, 5 and 6 of the 17. An edge has the same
/// weight in percentiles wherever it is judged.
const FEW_COUNTS: [u8; FEW] = [1, 6, 5, 6, 1];

pub const FEW: usize = 5;

/// Codes or degrees: half of what the guarantee allows the 99.9th percentile.
pub const FEW_LIMIT: f32 = 0.5;

/// What the two sides of an edge differ by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Jumps {
    /// Nowhere by anything.
    Nothing,
    /// At [`FEW_POSITIONS`].
    Few([f32; FEW]),
    /// At every [`position`].
    All([f32; SAMPLES]),
}

/// Chunks an edge list is split into; fewer would leave processors idle, more would cost histograms.
const CHUNKS: usize = 32;

/// The share of the samples that lie at or under a percentile, as a fraction of whole numbers.
const P999: (u64, u64) = (999, 1000);

/// Where along the edge a sample stands, 0 to 1.
pub fn position(sample: usize) -> f32 {
    match sample {
        0 => 0.0,
        s if s <= INTERIOR => (s as f32 - 0.5) / INTERIOR as f32,
        _ => 1.0,
    }
}

/// Figures over all edges, and each edge's mean jump (over its interior points, which are the midpoints
/// of 17 equal pieces; the ends enter the maximum and the percentile).
pub struct Survey {
    pub figures: Figures,
    pub edge_means: Vec<f32>,
}

/// Judges the pairs with the given indices.
pub fn survey<F>(pairs: &[EdgePair], which: &[u32], jumps: F) -> Survey
where
    F: Fn(&EdgePair) -> Jumps + Sync,
{
    let [survey] = surveys(pairs, which, |pair| [Some(jumps(pair))]);
    survey
}

/// The same for several kinds of jumps at once; a pair counts in a kind where it has any.
pub fn surveys<const N: usize, F>(pairs: &[EdgePair], which: &[u32], jumps: F) -> [Survey; N]
where
    F: Fn(&EdgePair) -> [Option<Jumps>; N] + Sync,
{
    let chunk = which.len().div_ceil(CHUNKS).max(64);
    let tallies: Vec<[Tally; N]> = which
        .par_chunks(chunk)
        .map(|which| {
            let mut tallies = [(); N].map(|()| Tally::default());
            for &pair in which {
                let pair = &pairs[pair as usize];
                for (tally, jumps) in tallies.iter_mut().zip(jumps(pair)) {
                    jumps.iter().for_each(|jumps| tally.add(jumps, pair.length));
                }
            }
            tallies
        })
        .collect();
    let mut totals = [(); N].map(|()| Tally::default());
    for tally in tallies {
        totals.iter_mut().zip(tally).for_each(|(total, tally)| total.join(tally));
    }
    totals.map(|total| Survey { figures: total.figures(), edge_means: total.edge_means })
}

/// The mean of edge means, weighted by length; `None` without edges.
pub fn weighted_mean(pairs: &[EdgePair], which: &[u32], means: impl Iterator<Item = f32>) -> Option<f64> {
    let (mut sum, mut weight) = (0.0, 0.0);
    for (&pair, mean) in which.iter().zip(means) {
        let length = f64::from(pairs[pair as usize].length);
        sum += length * f64::from(mean);
        weight += length;
    }
    (weight > 0.0).then(|| sum / weight)
}

#[derive(Default)]
struct Tally {
    jumps: Histogram,
    weighted_sum: f64,
    weight: f64,
    edge_means: Vec<f32>,
}

impl Tally {
    fn add(&mut self, jumps: &Jumps, length: f32) {
        let mean = match jumps {
            Jumps::Nothing => {
                self.jumps.add_times(0.0, SAMPLES as u64);
                0.0
            }
            Jumps::Few(jumps) => {
                let mut sum = 0.0;
                for (number, (&jump, count)) in jumps.iter().zip(FEW_COUNTS).enumerate() {
                    self.jumps.add_times(jump, u64::from(count));
                    sum += if (1..FEW - 1).contains(&number) { jump * f32::from(count) } else { 0.0 };
                }
                sum / INTERIOR as f32
            }
            Jumps::All(jumps) => {
                jumps.iter().for_each(|&jump| self.jumps.add_times(jump, 1));
                jumps[1..=INTERIOR].iter().sum::<f32>() / INTERIOR as f32
            }
        };
        self.weighted_sum += f64::from(length) * f64::from(mean);
        self.weight += f64::from(length);
        self.edge_means.push(mean);
    }

    fn join(&mut self, other: Self) {
        self.jumps.join(&other.jumps);
        self.weighted_sum += other.weighted_sum;
        self.weight += other.weight;
        self.edge_means.extend(other.edge_means);
    }

    fn figures(&self) -> Figures {
        Figures {
            max: self.jumps.max(),
            p999: self.jumps.percentile(P999),
            mean: if self.weight > 0.0 { self.weighted_sum / self.weight } else { 0.0 },
            sample_count: self.jumps.count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::edges::Side;

    fn edge(length: f32) -> EdgePair {
        let side = Side { part: 0, triangle: 0, corner: 0 };
        EdgePair { a: side, b: side, opposed: true, length }
    }

    #[test]
    fn the_percentile_is_a_rank() {
        // 1000 samples want the 999th: 20 edges of 19 samples are 380, whose 380th is the largest.
        let pairs: Vec<_> = (0..1000).map(|_| edge(1.0)).collect();
        let which: Vec<u32> = (0..1000).collect();
        let count = std::sync::atomic::AtomicUsize::new(0);
        let spiky = |outliers: usize| {
            count.store(0, std::sync::atomic::Ordering::SeqCst);
            survey(&pairs, &which, |_| {
                let edge = count.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
                let mut jumps = [0.5; SAMPLES];
                if edge < outliers {
                    jumps[4] = 40.0;
                }
                Jumps::All(jumps)
            })
            .figures
        };
        // 19 of 19 000 samples are one in a thousand: the rank is the last of the others.
        assert_eq!((spiky(19).p999, spiky(19).max), (0.5, 40.0));
        assert_eq!(spiky(20).p999, 40.0);
        assert_eq!(spiky(20).sample_count, 19_000);
    }

    #[test]
    fn a_percentile_of_exactly_one_code_stays_one_code() {
        let figures = survey(&[edge(1.0)], &[0], |_| Jumps::All([1.000_000_1; SAMPLES])).figures;
        assert_eq!(figures.p999, 1.0);
    }

    #[test]
    fn means_weigh_by_length_and_skip_the_ends() {
        let pairs = [edge(3.0), edge(1.0)];
        let result = survey(&pairs, &[0, 1], |pair| {
            let mut jumps = [if pair.length > 2.0 { 1.0 } else { 5.0 }; SAMPLES];
            jumps[0] = 100.0;
            jumps[SAMPLES - 1] = 100.0;
            Jumps::All(jumps)
        });
        assert_eq!((result.figures.mean, result.figures.max), (2.0, 100.0));
        assert_eq!(result.edge_means, vec![1.0, 5.0]);
        assert_eq!(weighted_mean(&pairs, &[1], [5.0].into_iter()), Some(5.0));
        assert_eq!(weighted_mean(&pairs, &[], [].into_iter()), None);
    }

    #[test]
    fn no_jump_is_a_jump_of_nothing() {
        let pairs = [edge(3.0), edge(1.0)];
        let with = |nothing: Jumps, two: Jumps| {
            survey(&pairs, &[0, 1], |pair| if pair.length > 2.0 { nothing } else { two })
        };
        let short = with(Jumps::Nothing, Jumps::All([2.0; SAMPLES]));
        for zeros in [Jumps::All([0.0; SAMPLES]), Jumps::Few([0.0; FEW])] {
            let long = with(zeros, Jumps::Few([2.0; FEW]));
            assert_eq!((short.figures, &short.edge_means), (long.figures, &long.edge_means));
        }
        assert_eq!((short.figures.mean, short.figures.sample_count), (0.5, 38));
    }

    #[test]
    fn few_positions_count_as_many_and_are_midpoints() {
        let pairs = [edge(1.0)];
        let few = survey(&pairs, &[0], |_| Jumps::Few(FEW_POSITIONS));
        let all = survey(&pairs, &[0], |_| Jumps::All(std::array::from_fn(position)));
        assert_eq!(few.figures.sample_count, all.figures.sample_count);
        assert!((few.figures.mean - 0.5).abs() < 1e-6 && (all.figures.mean - 0.5).abs() < 1e-6);
        let mut from = 0.0;
        for (at, count) in FEW_POSITIONS.into_iter().zip(FEW_COUNTS).skip(1).take(FEW - 2) {
            let to = from + f32::from(count) / INTERIOR as f32;
            assert!((at - 0.5 * (from + to)).abs() < 1e-6);
            from = to;
        }
        assert!((from - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_quadratic_hides_little_between_few_positions() {
        // All quadratics up to scale, by their values at the ends and in the middle.
        for (a, b) in (-20..=20).flat_map(|a| (-20..=20).map(move |b| (a as f32 / 20.0, b as f32 / 20.0))) {
            for middle in [-1.0, -0.5, 0.0, 0.5, 1.0] {
                let (slope, bend) = (4.0 * middle - 3.0 * a - b, 2.0 * a + 2.0 * b - 4.0 * middle);
                let at = |t: f32| (a + slope * t + bend * t * t).abs();
                let seen = FEW_POSITIONS.map(at).into_iter().fold(0.0, f32::max);
                let most = (0..=1000).map(|i| at(i as f32 / 1000.0)).fold(0.0, f32::max);
                assert!(seen >= 0.875 * most, "{a} {middle} {b}: {seen} of {most}");
            }
        }
    }

    #[test]
    fn no_edges_no_figures() {
        assert_eq!(survey(&[], &[], |_| Jumps::Nothing).figures, Figures::default());
    }

    #[test]
    fn positions_are_symmetric() {
        for sample in 0..SAMPLES {
            assert!((position(sample) + position(SAMPLES - 1 - sample) - 1.0).abs() < 1e-6);
        }
    }
}
