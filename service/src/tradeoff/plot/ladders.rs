//! Each ladder's rungs: time, errors and seams as figures with a short bar under each.

use super::super::record::{Done, End, Run, Rung, Tradeoff};
use super::super::words::{figure, time};
use super::unit;
use crate::plot::{Anchor, Style, Svg, ink, text_width};

const ROW_HEIGHT: f64 = 35.0;
const LADDER_GAP: f64 = 40.0;
const NAME_WIDTH: f64 = 176.0;
const HEADING: Style = Style::new(24.0, ink::TEXT).strong();
const COLUMN: Style = Style::new(19.0, ink::MUTED);
const LADDER: Style = Style::new(21.0, ink::TEXT).strong();
const SIZE: f64 = 20.0;

/// A column of figures.
struct Column {
    name: &'static str,
    value: fn(&Done) -> Option<f64>,
    shown: fn(f64) -> String,
    /// A full bar is this at least: what nobody would see must not look large.
    least_full: f64,
}

/// A conversion promises seams below this, codes.
const PROMISED_SEAM: f64 = 1.5;

fn columns(record: &Tradeoff) -> Vec<Column> {
    let seams = |done: &Done| done.errors.main().map(|(errors, _)| errors.seam_max);
    let all = [
        Column {
            name: "time",
            value: |done| Some(done.cost.converting_cpu_seconds),
            shown: time,
            least_full: 0.0,
        },
        Column { name: "level 0", value: Done::level_0_error, shown: figure, least_full: 0.0 },
        Column { name: "all levels", value: Done::mip_error, shown: figure, least_full: 0.0 },
        Column { name: "worst seam", value: seams, shown: figure, least_full: PROMISED_SEAM },
    ];
    let is_known =
        |column: &Column| record.runs.iter().filter_map(Run::done).any(|done| (column.value)(done).is_some());
    all.into_iter().filter(is_known).collect()
}

/// Height of everything below the top.
pub fn height(record: &Tradeoff) -> f64 {
    let rungs: usize = record.ladders.iter().map(|ladder| ladder.rungs.len()).sum();
    rungs as f64 * ROW_HEIGHT + record.ladders.len() as f64 * LADDER_GAP + 24.0
}

/// Draws from `[left, top]` on, in a width.
pub fn draw(svg: &mut Svg, record: &Tradeoff, [left, top, width]: [f64; 3]) {
    svg.text([left, top - 14.0], HEADING, "One rung changed");
    let words = format!("in standard; errors in {}", unit(record));
    svg.text([left + text_width("One rung changed", HEADING.size) + 14.0, top - 14.0], COLUMN, &words);
    let columns = columns(record);
    let step = (width - NAME_WIDTH) / columns.len() as f64;
    let mut y = top + 20.0;
    for (number, column) in columns.iter().enumerate() {
        svg.text([left + NAME_WIDTH + step * number as f64, y], COLUMN, column.name);
    }
    for ladder in &record.ladders {
        y += LADDER_GAP;
        svg.text([left, y], LADDER, &ladder.name);
        svg.line(
            &[[left + text_width(&ladder.name, LADDER.size) + 16.0, y - 7.0], [left + width, y - 7.0]],
            1.0,
            ink::GRID,
        );
        for rung in &ladder.rungs {
            y += ROW_HEIGHT;
            draw_rung(svg, record, rung, &columns, ([left, y], step));
        }
    }
}

fn draw_rung(
    svg: &mut Svg,
    record: &Tradeoff,
    rung: &Rung,
    columns: &[Column],
    ([left, y], step): ([f64; 2], f64),
) {
    let Some(run) = record.runs.get(rung.run) else { return };
    let ink = if rung.is_home { ink::AMBER } else { ink::TEXT };
    let style = Style::new(SIZE, ink);
    svg.text([left + 18.0, y], if rung.is_home { style.strong() } else { style }, &rung.name);
    let done = match &run.end {
        End::Done(done) => done,
        End::Refused { reason, .. } => {
            let words = cut(&format!("refused: {reason}"), SIZE, step * columns.len() as f64);
            svg.text([left + NAME_WIDTH, y], COLUMN, &words);
            return;
        }
    };
    for (number, column) in columns.iter().enumerate() {
        let Some(value) = (column.value)(done) else { continue };
        let x = left + NAME_WIDTH + step * number as f64;
        svg.text([x, y], style.anchored(Anchor::Start), &(column.shown)(value));
        let length = (step - 22.0) * share(record, column, value);
        svg.rectangle(
            [x, y + 6.0, length.max(1.0), 4.0],
            2.0,
            if rung.is_home { ink::AMBER } else { ink::FAINT },
        );
    }
}

/// A value over the largest of its column.
fn share(record: &Tradeoff, column: &Column, value: f64) -> f64 {
    let rungs = record.ladders.iter().flat_map(|ladder| &ladder.rungs);
    let runs = rungs.filter_map(|rung| record.runs.get(rung.run)).filter_map(Run::done);
    let most = runs.filter_map(column.value).fold(column.least_full, f64::max);
    if most > 0.0 { value / most } else { 0.0 }
}

/// The words as far as they fit.
fn cut(words: &str, size: f64, width: f64) -> String {
    if text_width(words, size) <= width {
        return words.to_owned();
    }
    let mut kept = String::new();
    for c in words.chars() {
        if text_width(&kept, size) + 2.0 * size > width {
            break;
        }
        kept.push(c);
    }
    kept + "…"
}
