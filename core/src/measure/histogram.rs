//! Ranks of many values without keeping them: counted in hundredths of a unit, in integers, so that the
//! order of counting does not matter.

const BINS_PER_UNIT: f32 = 100.0;

/// Values at or above 0, rounded to hundredths, and the exact largest.
#[derive(Clone, Debug, Default)]
pub struct Histogram {
    bins: Vec<u64>,
    max: f32,
}

impl Histogram {
    #[inline]
    pub fn add(&mut self, value: f32) {
        self.add_times(value, 1);
    }

    /// Adds the value so many times.
    #[inline]
    pub fn add_times(&mut self, value: f32, count: u64) {
        let bin = (value * BINS_PER_UNIT + 0.5) as usize;
        if bin >= self.bins.len() {
            self.bins.resize(bin + 1, 0);
        }
        self.bins[bin] += count;
        self.max = self.max.max(value);
    }

    pub fn join(&mut self, other: &Self) {
        if self.bins.len() < other.bins.len() {
            self.bins.resize(other.bins.len(), 0);
        }
        self.bins.iter_mut().zip(&other.bins).for_each(|(sum, count)| *sum += count);
        self.max = self.max.max(other.max);
    }

    pub fn count(&self) -> u64 {
        self.bins.iter().sum()
    }

    pub fn max(&self) -> f64 {
        f64::from(self.max)
    }

    /// The smallest value, in hundredths, that at least `part` of `whole` of the values do not exceed;
    /// never above the largest value.
    pub fn percentile(&self, (part, whole): (u64, u64)) -> f64 {
        let wanted = (self.count() * part).div_ceil(whole);
        let mut seen = 0;
        for (bin, count) in self.bins.iter().enumerate() {
            seen += count;
            if seen >= wanted {
                return (bin as f64 / f64::from(BINS_PER_UNIT)).min(self.max());
            }
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_do_not_depend_on_the_order_or_the_parts() {
        let (mut whole, mut first, mut second) =
            (Histogram::default(), Histogram::default(), Histogram::default());
        for value in 0..1000u32 {
            whole.add(value as f32 * 0.01);
            if value % 3 == 0 { &mut second } else { &mut first }.add((999 - value) as f32 * 0.01);
        }
        second.join(&first);
        for part in [1, 500, 990, 999, 1000] {
            assert!((whole.percentile((part, 1000)) - (part - 1) as f64 / 100.0).abs() < 1e-6);
        }
        assert_eq!(second.percentile((1, 2)), 4.99);
        assert_eq!((second.count(), second.max()), (1000, f64::from(9.99f32)));
    }

    #[test]
    fn nothing_has_no_rank() {
        assert_eq!((Histogram::default().percentile((1, 2)), Histogram::default().max()), (0.0, 0.0));
    }
}
