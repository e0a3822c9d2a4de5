//! The record as text: seconds by stage, nanoseconds for each face and doubling, memory, exponents.

use std::fmt::Write;

use super::{Scaling, Series};

/// Everything that was measured.
pub fn text(scaling: &Scaling) -> String {
    let mut text = String::new();
    let memory = scaling.memory();
    block(&mut text, "stages of standard, CPU seconds", &scaling.stages(), true);
    block(&mut text, "runs without reading, measuring, writing, CPU seconds", &scaling.runs(), true);
    block(&mut text, "peak memory of standard, MiB", &[memory], false);
    text
}

/// One line for each series: its figures, then of times nanoseconds over n·log2(n) at its own largest size, and the
/// exponent.
fn block(text: &mut String, heading: &str, series: &[Series], are_times: bool) {
    let sizes = series.iter().max_by_key(|series| series.points.len()).map(|series| &series.points);
    // Writing to a string cannot fail.
    let _ = write!(text, "{heading}\n{:18}", "faces");
    for (faces, _) in sizes.into_iter().flatten() {
        let _ = write!(text, "{faces:>11}");
    }
    if are_times {
        let _ = write!(text, "{:>17}", "ns / (n log2 n)");
    }
    let _ = writeln!(text, "{:>10}", "exponent");
    for series in series {
        let _ = write!(text, "{:18}", series.name);
        for (faces, _) in sizes.into_iter().flatten() {
            let found = series.points.iter().find(|point| point.0 == *faces);
            let _ = write!(text, "{:>11}", found.map_or_else(String::new, |point| format!("{:.4}", point.1)));
        }
        let last = series.points.last();
        let each = last.map(|(faces, value)| value * 1e9 / (faces * faces.log2()));
        let shown = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.2}"));
        if are_times {
            let _ = write!(text, "{:>17}", shown(each));
        }
        let _ = writeln!(text, "{:>10}", shown(series.exponent()));
    }
    text.push('\n');
}
