//! Axes: a range of values over a span of pixels, with round ticks.

/// Linear or logarithmic.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Values at both ends; of a logarithmic axis, their logarithms to base 10.
    range: [f64; 2],
    pixels: [f64; 2],
    is_log: bool,
}

impl Axis {
    /// A linear axis over the values, from zero on unless that would squeeze them into its far half or some are below.
    pub fn linear(values: impl Iterator<Item = f64>, pixels: [f64; 2]) -> Self {
        let [low, high] = extent(values).unwrap_or([0.0, 1.0]);
        let margin = ((high - low) * 0.24).max(high.abs() * 0.02).max(1e-9);
        let start = if (0.0..high * 0.5).contains(&low) { 0.0 } else { low - margin };
        Self { range: [start, high + margin], pixels, is_log: false }
    }

    /// A logarithmic axis over the positive values, `factor` wider at each end.
    pub fn log(values: impl Iterator<Item = f64>, factor: f64, pixels: [f64; 2]) -> Self {
        let [low, high] = extent(values.filter(|value| *value > 0.0)).unwrap_or([1.0, 10.0]);
        Self { range: [(low / factor).log10(), (high * factor).log10()], pixels, is_log: true }
    }

    /// The pixel of a value.
    pub fn at(&self, value: f64) -> f64 {
        let value = if self.is_log { value.max(f64::MIN_POSITIVE).log10() } else { value };
        let share = (value - self.range[0]) / (self.range[1] - self.range[0]);
        self.pixels[0] + share * (self.pixels[1] - self.pixels[0])
    }

    /// Round values inside, about `count` of them.
    pub fn ticks(&self, count: usize) -> Vec<f64> {
        if self.is_log { self.log_ticks(count) } else { self.linear_ticks(count) }
    }

    fn linear_ticks(&self, count: usize) -> Vec<f64> {
        let rough = (self.range[1] - self.range[0]) / count.max(1) as f64;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|n| n * power).into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * power);
        let (first, last) = ((self.range[0] / step).ceil() as i64, (self.range[1] / step).floor() as i64);
        (first..=last).map(|n| n as f64 * step).collect()
    }

    /// Powers of ten, split finer until there are enough.
    fn log_ticks(&self, count: usize) -> Vec<f64> {
        let splits: [&[f64]; 4] =
            [&[1.0], &[1.0, 3.0], &[1.0, 2.0, 5.0], &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0]];
        let powers = self.range[0].floor() as i32..=self.range[1].ceil() as i32;
        let ticks = |split: &[f64]| -> Vec<f64> {
            let all = powers.clone().flat_map(|power| split.iter().map(move |n| n * 10f64.powi(power)));
            all.filter(|tick| (self.range[0]..=self.range[1]).contains(&tick.log10())).collect()
        };
        let found = splits.iter().map(|split| ticks(split)).find(|ticks| ticks.len() >= count);
        found.unwrap_or_else(|| ticks(splits[3]))
    }
}

/// Least and largest finite value.
fn extent(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let both = values.filter(|value| value.is_finite()).map(|value| [value, value]);
    both.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_axes_start_at_zero_where_that_costs_little() {
        let axis = Axis::linear([1.0, 4.0].into_iter(), [100.0, 0.0]);
        assert_eq!(axis.at(0.0), 100.0);
        let axis = Axis::linear([9.0, 10.0].into_iter(), [100.0, 0.0]);
        assert!(axis.at(9.0) > 80.0 && axis.at(10.0) < 20.0);
        assert!(axis.ticks(4).iter().all(|tick| (8.7..=10.3).contains(tick)));
        let axis = Axis::linear([-2.0, 3.0].into_iter(), [100.0, 0.0]);
        assert!(axis.at(-2.0) < 100.0 && axis.at(3.0) > 0.0);
    }

    #[test]
    fn equal_steps_are_equal_factors_on_log_axes() {
        let axis = Axis::log([1.0, 100.0].into_iter(), 1.0, [0.0, 200.0]);
        assert_eq!([1.0, 10.0, 100.0].map(|value| axis.at(value).round()), [0.0, 100.0, 200.0]);
        assert_eq!(axis.ticks(3), [1.0, 10.0, 100.0]);
        assert!(Axis::log([1.0, 1.5].into_iter(), 1.1, [0.0, 1.0]).ticks(3).len() >= 3);
    }

    #[test]
    fn axes_without_values_or_with_one_stay_finite() {
        for values in [vec![], vec![0.0], vec![3.0], vec![f64::NAN]] {
            let linear = Axis::linear(values.iter().copied(), [0.0, 10.0]);
            let log = Axis::log(values.iter().copied(), 1.2, [0.0, 10.0]);
            assert!(linear.at(3.0).is_finite() && log.at(3.0).is_finite(), "{values:?}");
            assert!(linear.ticks(4).len() < 50 && log.ticks(4).len() < 50, "{values:?}");
        }
    }
}
