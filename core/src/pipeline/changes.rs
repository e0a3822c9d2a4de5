//! How far a level's samples are from what was wanted, in figures.

/// Over all samples of a level, in codes.
pub struct Changes {
    pub mean_codes: f64,
    /// The smallest change that 95 % of the samples do not exceed.
    pub p95_codes: f64,
    pub max_codes: f64,
}

impl Changes {
    /// One figure for each sample.
    pub fn new(changes: Vec<f64>) -> Self {
        let count = changes.len();
        Self::among(changes, count)
    }

    /// Of `count` samples, those that are not in `changes` having none.
    pub fn among(mut changes: Vec<f64>, count: usize) -> Self {
        let mean_codes = changes.iter().sum::<f64>() / count.max(1) as f64;
        let max_codes = changes.iter().copied().fold(0.0, f64::max);
        let above = count - (count * 95).div_ceil(100);
        let p95 = changes.len().checked_sub(above + 1);
        let p95_codes = p95.map_or(0.0, |at| *changes.select_nth_unstable_by(at, f64::total_cmp).1);
        Self { mean_codes, p95_codes, max_codes }
    }
}

#[cfg(test)]
mod tests {
    use super::Changes;

    #[test]
    fn samples_that_stay_count_as_none() {
        let some = Changes::among(vec![8.0, 2.0, 4.0], 40);
        assert_eq!((some.mean_codes, some.p95_codes, some.max_codes), (0.35, 2.0, 8.0));
        let few = Changes::among(vec![8.0], 40);
        assert_eq!((few.p95_codes, few.max_codes), (0.0, 8.0));
        let all = Changes::new((1..=20).map(f64::from).collect());
        assert_eq!((all.p95_codes, all.max_codes), (19.0, 20.0));
    }
}
