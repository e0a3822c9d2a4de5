//! The picture: on the left error against time for whole presets and every rung, on the right each
//! ladder's rungs side by side. Every label stands at what it names.

mod curve;
mod curve_panel;
mod ladders;
mod scatter;

pub use curve::{one as curve_svg, several as curves_svg};

use super::plan::HOME;
use super::record::{Done, Run, Tradeoff};
use super::words::{grouped, headline};
use crate::plot::{Style, Svg, ink, text_width};
use scatter::Panel;

const WIDTH: f64 = 1600.0;
const MARGIN: f64 = 52.0;
/// Where the ladders begin.
const LADDERS_LEFT: f64 = 872.0;
/// Where pictures begin under a headline of one line.
const TOP: f64 = 172.0;
const LINE_HEIGHT: f64 = 42.0;
const HEADLINE: Style = Style::new(33.0, ink::TEXT).strong();
const SUBTITLE: Style = Style::new(21.0, ink::MUTED);

/// The picture as SVG, the same bytes for the same record.
pub fn svg(record: &Tradeoff) -> String {
    let lines = wrapped(&headline(record), HEADLINE, WIDTH - 2.0 * MARGIN);
    let below_first = LINE_HEIGHT * (lines.len() as f64 - 1.0);
    let top = TOP + below_first;
    let height = top + ladders::height(record) + 40.0;
    let mut svg = Svg::new(WIDTH, height, &format!("{}: {}", record.model, headline(record)));
    for (number, line) in lines.iter().enumerate() {
        svg.text([MARGIN, 62.0 + LINE_HEIGHT * number as f64], HEADLINE, line);
    }
    let repeats = if record.repeat_count == 1 { "once" } else { "repeatedly, the fastest counting" };
    let subtitle = format!(
        "{} · {} faces · every rung run {repeats} · time is CPU seconds of all threads",
        record.model,
        grouped(record.face_count)
    );
    svg.text([MARGIN, 100.0 + below_first], SUBTITLE, &subtitle);
    let panels = panels(record);
    let gap = 88.0;
    let room = (height - top - 40.0 + gap) / panels.len() as f64 - gap;
    for (number, panel) in panels.iter().enumerate() {
        let top = top + (room + gap) * number as f64;
        scatter::draw(&mut svg, record, panel, [MARGIN, top, LADDERS_LEFT - 76.0 - MARGIN, room]);
    }
    ladders::draw(&mut svg, record, [LADDERS_LEFT, top, WIDTH - MARGIN - LADDERS_LEFT]);
    svg.finish()
}

/// The errors that the record has: always that of level 0, and that over all levels where it was measured.
fn panels(record: &Tradeoff) -> Vec<Panel> {
    let has_mips = record.runs.iter().any(|run| run.done().and_then(Done::mip_error).is_some());
    let fine = Panel {
        title: "Sharpness: error at level 0",
        error: Done::level_0_error,
        is_on_front: |done| done.is_on_front,
        has_time_words: !has_mips,
    };
    let coarse = Panel {
        title: "Mip maps: error over all levels",
        error: Done::mip_error,
        is_on_front: |done| done.is_on_mip_front,
        has_time_words: true,
    };
    if has_mips { vec![fine, coarse] } else { vec![fine] }
}

/// The unit of the record's errors.
fn unit(record: &Tradeoff) -> &'static str {
    record.runs.iter().find_map(|run| Some(run.done()?.errors.main()?.1)).unwrap_or("codes")
}

/// A preset's color.
fn preset_ink(name: &str) -> &'static str {
    match name {
        HOME => ink::AMBER,
        "draft" => ink::TEAL,
        _ => ink::CORAL,
    }
}

/// The presets whose rungs a run has.
fn presets_of<'a>(record: &'a Tradeoff, run: &Run) -> impl Iterator<Item = &'a str> {
    let place = record.runs.iter().position(|other| std::ptr::eq(other, run));
    let presets = record.presets.iter().filter(move |preset| Some(preset.run) == place);
    presets.map(|preset| preset.name.as_str())
}

/// Words in lines no wider than `width`.
fn wrapped(words: &str, style: Style, width: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in words.split(' ') {
        let last = lines.len() - 1;
        let longer = if lines[last].is_empty() { word.to_owned() } else { format!("{} {word}", lines[last]) };
        if !lines[last].is_empty() && text_width(&longer, style.size) > width {
            lines.push(word.to_owned());
        } else {
            lines[last] = longer;
        }
    }
    lines
}
