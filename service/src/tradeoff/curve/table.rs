//! The curve as a Markdown table, and the one sentence that it comes to.

use super::super::table::table as markdown_table;
use super::super::words::{grouped, short_count, signed};
use super::{Curve, Figures, Line, Point, PointEnd};

/// Every run of the curve.
pub fn table(curve: &Curve) -> String {
    let heading = [
        "run",
        "texels",
        "a face",
        "PSNR, dB",
        "plain, dB",
        "gain, dB",
        "mean gain, all maps",
        "worst map",
        "best map",
    ];
    let rows = curve.lines.iter().flat_map(|line| line.points.iter().map(move |point| (line, point)));
    let row = |(line, point): (&Line, &Point)| {
        let mut cells = vec![format!("{}, {}", line.name, share(point.share))];
        match &point.end {
            PointEnd::Done(figures) => cells.extend(figure_cells(figures)),
            PointEnd::Refused { reason, .. } => {
                cells.push(format!("refused: {}", reason.replace('|', "\\|")))
            }
        }
        cells.resize(heading.len(), String::new());
        cells
    };
    markdown_table(&heading, rows.map(row))
}

fn figure_cells(figures: &Figures) -> Vec<String> {
    let mut cells = vec![
        grouped(figures.texels),
        format!("{:.1}", figures.texels as f64 / figures.stored_face_count.max(1) as f64),
    ];
    if let (Some([ours, plain]), Some(gains)) = (figures.color_psnr_db(), figures.gains_db()) {
        cells.extend([format!("{ours:.1}"), format!("{plain:.1}"), signed(ours - plain)]);
        cells.extend(gains.map(signed));
    }
    cells
}

/// A share as a fraction.
fn share(share: f64) -> String {
    if share >= 1.0 { "whole area".to_owned() } else { format!("1/{:.0} of the area", 1.0 / share) }
}

/// What fitted budgets are against plain resampling to as many texels, over all maps, wherever faces have more texels than
/// their corners need. `None` where there is no such run.
pub fn headline(curve: &Curve) -> Option<String> {
    let figures = || curve.best().into_iter().flat_map(Line::done).filter(|figures| figures.is_above_floor());
    let gains: Vec<(u64, [f64; 3])> = figures().filter_map(|f| Some((f.texels, f.gains_db()?))).collect();
    let (low, high) = ends(gains.iter().map(|(_, gains)| gains[0]))?;
    let ahead_count = gains.iter().take_while(|(_, gains)| gains[0] > -NOTICED_DB).count();
    let words = match gains.get(ahead_count) {
        None => format!("Nearer than plain resampling at every size, by {low:.1} to {high:.1} dB"),
        Some((texels, [under, ..])) if ahead_count > 0 => format!(
            "Nearer than plain resampling up to {} texels, by up to {high:.1} dB; {:.1} dB under it at {}",
            short_count(gains[ahead_count - 1].0 as f64),
            under.abs(),
            short_count(*texels as f64),
        ),
        Some(_) => format!("{} to {} dB against plain resampling", signed(low), signed(high)),
    };
    let map_count = figures().map(|f| f.maps.len()).max().unwrap_or(0);
    if map_count < 2 {
        return Some(words);
    }
    let (worst, _) = ends(gains.iter().map(|(_, [_, least, _])| *least))?;
    Some(format!("{words}; the worst of {map_count} maps {} dB", signed(worst)))
}

/// What shows in one digit.
const NOTICED_DB: f64 = 0.05;

/// The least and the largest.
fn ends(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.map(|v| (v, v)).reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
}
