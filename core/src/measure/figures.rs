//! Statistics of jumps along edges. Percentiles come from a histogram of 0.01 units, counted in integers;
//! means are summed in the order of the edges in chunks whose bounds depend on the edges' number alone:
//! the same figures with any number of threads.

use rayon::prelude::*;

use super::edges::EdgePair;
use super::report::Figures;

/// Points inside an edge, at (k + 1/2) / 17: no power of two divides 17, so they fall between texel
/// centers at every resolution.
pub const INTERIOR: usize = 17;

/// The interior points and the two ends.
pub const SAMPLES: usize = INTERIOR + 2;

const BINS_PER_UNIT: f32 = 100.0;

/// Chunks an edge list is split into; fewer would leave processors idle, more would cost histograms.
const CHUNKS: usize = 64;

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
    F: Fn(&EdgePair) -> [f32; SAMPLES] + Sync,
{
    let chunk = which.len().div_ceil(CHUNKS).max(64);
    let tallies: Vec<Tally> = which
        .par_chunks(chunk)
        .map(|which| {
            let mut tally = Tally::default();
            for &pair in which {
                let pair = &pairs[pair as usize];
                tally.add(&jumps(pair), pair.length);
            }
            tally
        })
        .collect();
    let mut total = Tally::default();
    for tally in tallies {
        total.join(tally);
    }
    Survey { figures: total.figures(), edge_means: total.edge_means }
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
    /// Samples by rounded hundredth of a unit.
    bins: Vec<u64>,
    max: f32,
    weighted_sum: f64,
    weight: f64,
    edge_means: Vec<f32>,
}

impl Tally {
    fn add(&mut self, jumps: &[f32; SAMPLES], length: f32) {
        for &jump in jumps {
            let bin = (jump * BINS_PER_UNIT + 0.5) as usize;
            if bin >= self.bins.len() {
                self.bins.resize(bin + 1, 0);
            }
            self.bins[bin] += 1;
            self.max = self.max.max(jump);
        }
        let mean = jumps[1..=INTERIOR].iter().sum::<f32>() / INTERIOR as f32;
        self.weighted_sum += f64::from(length) * f64::from(mean);
        self.weight += f64::from(length);
        self.edge_means.push(mean);
    }

    fn join(&mut self, other: Self) {
        if self.bins.len() < other.bins.len() {
            self.bins.resize(other.bins.len(), 0);
        }
        self.bins.iter_mut().zip(&other.bins).for_each(|(sum, count)| *sum += count);
        self.max = self.max.max(other.max);
        self.weighted_sum += other.weighted_sum;
        self.weight += other.weight;
        self.edge_means.extend(other.edge_means);
    }

    fn figures(&self) -> Figures {
        let sample_count: u64 = self.bins.iter().sum();
        let mean = if self.weight > 0.0 { self.weighted_sum / self.weight } else { 0.0 };
        let max = f64::from(self.max);
        Figures { max, p999: self.percentile(sample_count, P999).min(max), mean, sample_count }
    }

    /// The smallest value, in hundredths, that at least the given share of the samples does not exceed.
    fn percentile(&self, sample_count: u64, (part, whole): (u64, u64)) -> f64 {
        let wanted = (sample_count * part).div_ceil(whole);
        let mut seen = 0;
        for (bin, count) in self.bins.iter().enumerate() {
            seen += count;
            if seen >= wanted {
                return bin as f64 / f64::from(BINS_PER_UNIT);
            }
        }
        0.0
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
                jumps
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
        let figures = survey(&[edge(1.0)], &[0], |_| [1.000_000_1; SAMPLES]).figures;
        assert_eq!(figures.p999, 1.0);
    }

    #[test]
    fn means_weigh_by_length_and_skip_the_ends() {
        let pairs = [edge(3.0), edge(1.0)];
        let result = survey(&pairs, &[0, 1], |pair| {
            let mut jumps = [if pair.length > 2.0 { 1.0 } else { 5.0 }; SAMPLES];
            jumps[0] = 100.0;
            jumps[SAMPLES - 1] = 100.0;
            jumps
        });
        assert_eq!((result.figures.mean, result.figures.max), (2.0, 100.0));
        assert_eq!(result.edge_means, vec![1.0, 5.0]);
        assert_eq!(weighted_mean(&pairs, &[1], [5.0].into_iter()), Some(5.0));
        assert_eq!(weighted_mean(&pairs, &[], [].into_iter()), None);
    }

    #[test]
    fn no_edges_no_figures() {
        assert_eq!(survey(&[], &[], |_| [0.0; SAMPLES]).figures, Figures::default());
    }

    #[test]
    fn positions_are_symmetric() {
        for sample in 0..SAMPLES {
            assert!((position(sample) + position(SAMPLES - 1 - sample) - 1.0).abs() < 1e-6);
        }
    }
}
