//! The Pareto front: the runs that no other run beats in both time and error.

/// Which of the points (time, error) are on the front. Of equal points all are.
pub fn front(points: &[Option<(f64, f64)>]) -> Vec<bool> {
    let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
    let is_beaten = |point| points.iter().flatten().any(|other| beats(*other, point));
    points.iter().map(|point| point.is_some_and(|point| !is_beaten(point))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_beaten_in_both_is_not_on_it() {
        let points = [
            Some((1.0, 9.0)),
            Some((2.0, 5.0)),
            Some((2.0, 5.0)),
            Some((3.0, 5.0)),
            None,
            Some((4.0, 1.0)),
            Some((5.0, 2.0)),
        ];
        assert_eq!(front(&points), [true, true, true, false, false, true, false]);
    }
}
