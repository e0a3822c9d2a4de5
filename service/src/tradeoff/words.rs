//! Figures as people read them, and the one sentence that the record comes to.

use super::plan::HOME;
use super::record::{Done, Tradeoff};

/// Three digits or so.
pub fn figure(value: f64) -> String {
    match value.abs() {
        v if v >= 99.95 => format!("{value:.0}"),
        v if v >= 9.995 => format!("{value:.1}"),
        v if v >= 0.0995 || v == 0.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

/// A time with its unit.
pub fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 9.95 => format!("{s:.0} s"),
        s if s >= 0.95 => format!("{s:.1} s"),
        s if s >= 0.0995 => format!("{s:.2} s"),
        s => format!("{:.0} ms", s * 1000.0),
    }
}

/// A difference with its sign.
pub fn signed(value: f64) -> String {
    let text = format!("{:.1}", value.abs());
    match text.as_str() {
        "0.0" => text,
        _ if value < 0.0 => format!("−{text}"),
        _ => format!("+{text}"),
    }
}

/// A count of texels, short.
pub fn short_count(count: f64) -> String {
    let (value, unit) = match count {
        c if c >= 0.9995e6 => (c / 1e6, " M"),
        c if c >= 999.5 => (c / 1e3, " k"),
        c => (c, ""),
    };
    let text = if value >= 99.5 || unit.is_empty() { format!("{value:.0}") } else { format!("{value:.1}") };
    format!("{}{unit}", text.strip_suffix(".0").unwrap_or(&text))
}

/// A count in groups of three digits.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let groups = digits.as_bytes().rchunks(3).rev().map(|group| String::from_utf8_lossy(group));
    groups.collect::<Vec<_>>().join(" ")
}

/// A factor.
pub fn times(factor: f64) -> String {
    if factor >= 9.95 { format!("{factor:.0}×") } else { format!("{factor:.1}×") }
}

/// Memory in MiB.
pub fn mib(bytes: Option<u64>) -> String {
    bytes.map_or_else(String::new, |bytes| format!("{:.0}", bytes as f64 / f64::from(1 << 20)))
}

/// What `standard` takes and gives, and what the other presets would.
pub fn headline(record: &Tradeoff) -> String {
    let preset = |name: &str| record.preset(name).and_then(|run| run.done());
    let Some(home) = preset(HOME) else { return record.model.clone() };
    let seconds = home.cost.converting_cpu_seconds;
    let Some((errors, unit)) = home.errors.main() else {
        return format!("{HOME}: {} of computing", time(seconds));
    };
    let mut sentence =
        format!("{HOME}: {} of computing, {} {unit} RMS", time(seconds), figure(errors.level_0.rms));
    for other in record.presets.iter().filter(|preset| preset.name != HOME) {
        if let Some(done) = preset(&other.name) {
            sentence += &format!("; {} {}", other.name, against(home, done, unit));
            if home.is_seamless && !done.is_seamless {
                sentence += &format!(" and leaves seams of {} {unit}", figure(seam(done)));
            }
        }
    }
    sentence
}

/// The largest seam of a run.
pub fn seam(done: &Done) -> f64 {
    done.errors.main().map_or(0.0, |(errors, _)| errors.seam_max)
}

/// Half a percent is no difference to speak of.
const NOTICED: f64 = 0.005;

/// Nor is a twentieth of a time, which the next run may give back.
const SAME_TIME: f64 = 0.05;

/// What another preset does with more or less time.
fn against(home: &Done, other: &Done, unit: &str) -> String {
    let factor = other.cost.converting_cpu_seconds / home.cost.converting_cpu_seconds.max(1e-9);
    let error = |done: &Done| done.level_0_error().unwrap_or(0.0);
    let (before, after) = (error(home), error(other));
    let gained = before - after;
    let is_nearer = gained > NOTICED * before;
    let is_farther = -gained > NOTICED * before;
    let difference = format!("{} {unit}", figure(gained.abs()));
    if (1.0 - factor).abs() < SAME_TIME {
        return match (is_nearer, is_farther) {
            (true, _) => format!("gains {difference} in the same time"),
            (_, true) => format!("loses {difference} in the same time"),
            _ => "is the same here".to_owned(),
        };
    }
    match (factor < 1.0, is_nearer, is_farther) {
        (true, true, _) => format!("gains {difference} in {} of the time", percent(factor)),
        (true, _, true) => format!("saves {} of the time for {difference} more", percent(1.0 - factor)),
        (true, ..) => format!("saves {} of the time at the same error", percent(1.0 - factor)),
        (false, true, _) => format!("buys {difference} for {} the time", times(factor)),
        (false, _, true) => format!("takes {} the time and loses {difference}", times(factor)),
        (false, ..) => format!("takes {} the time for the same error", times(factor)),
    }
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_three_digits_or_so() {
        assert_eq!(
            [123.4, 12.34, 1.234, 0.1234, 0.01234, 0.0].map(figure),
            ["123", "12.3", "1.23", "0.12", "0.012", "0.00"]
        );
        assert_eq!([12.3, 1.23, 0.123, 0.0123].map(time), ["12 s", "1.2 s", "0.12 s", "12 ms"]);
        assert_eq!([12, 1_234, 1_234_567].map(grouped), ["12", "1 234", "1 234 567"]);
        assert_eq!([12.3, 1.23].map(times), ["12×", "1.2×"]);
        assert_eq!(
            [1.23, -1.25, -0.04].map(signed),
            ["+1.2", "− 1.2", "0.0"].map(|text| text.replace(' ', ""))
        );
        assert_eq!([12.0, 1_000.0, 243_210.0, 3.2e6].map(short_count), ["12", "1 k", "243 k", "3.2 M"]);
    }
}
