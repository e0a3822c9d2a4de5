//! The pictures of texels against error: one model large, or several side by side. Above, PSNR against texels; below or
//! beside, the same runs against the source resampled to as many texels, which is the line to stay above.

use super::super::curve::{Curve, headline};
use super::super::record::Tradeoff;
use super::super::words::{grouped, short_count};
use super::curve_panel::{self, Kind, Panel, inks};
use super::wrapped;
use crate::plot::{Style, Svg, ink, text_width};

const WIDTH: f64 = 1600.0;
const MARGIN: f64 = 52.0;
const LINE_HEIGHT: f64 = 42.0;
const HEADLINE: Style = Style::new(33.0, ink::TEXT).strong();
const SUBTITLE: Style = Style::new(21.0, ink::MUTED);
const TITLE: Style = Style::new(24.0, ink::TEXT).strong();
const NOTE: Style = Style::new(19.0, ink::MUTED);
const LEGEND: f64 = 21.0;

/// One model's picture; `None` without a curve, or where none of its runs came to an end.
pub fn one(record: &Tradeoff) -> Option<String> {
    const PANEL_HEIGHT: f64 = 470.0;
    let curve = record.curve.as_ref()?;
    let words = headline(curve)?;
    let lines = wrapped(&words, HEADLINE, WIDTH - 2.0 * MARGIN);
    let legend = 110.0 + LINE_HEIGHT * (lines.len() as f64 - 1.0) + 40.0;
    let top = legend + 92.0;
    let mut svg = Svg::new(WIDTH, top + PANEL_HEIGHT + 96.0, &format!("{}: {words}", record.model));
    for (number, line) in lines.iter().enumerate() {
        svg.text([MARGIN, 62.0 + LINE_HEIGHT * number as f64], HEADLINE, line);
    }
    let source = curve
        .source_texels
        .map_or_else(String::new, |texels| format!(" · source of {} texels", short_count(texels as f64)));
    let subtitle = format!("{} · {} faces{source}", record.model, grouped(record.face_count));
    svg.text([MARGIN, legend - 50.0], SUBTITLE, &subtitle);
    draw_legend(&mut svg, curve, [MARGIN, legend]);
    let gap = 64.0;
    let width = (WIDTH - 2.0 * MARGIN - gap) / 2.0;
    let kinds = [
        (Kind::Psnr, "Base color: PSNR, dB", "higher is nearer".to_owned()),
        (Kind::Gain, "Against plain resampling, dB", of_maps(curve)),
    ];
    for (number, (kind, title, note)) in kinds.into_iter().enumerate() {
        let left = MARGIN + (width + gap) * number as f64;
        svg.text([left, top - 16.0], TITLE, title);
        svg.text([left + text_width(title, TITLE.size) + 14.0, top - 16.0], NOTE, &note);
        let panel = Panel { curve, kind, place: [left, top, width, PANEL_HEIGHT], tick_counts: [4, 5] };
        curve_panel::draw(&mut svg, &panel);
    }
    let words = "texels of level 0, one map";
    let place = [WIDTH - MARGIN - text_width(words, NOTE.size), top + PANEL_HEIGHT + 60.0];
    svg.text(place, NOTE, words);
    Some(svg.finish())
}

/// What the second panel's lines and bars are.
fn of_maps(curve: &Curve) -> String {
    let count = curve.lines.iter().flat_map(|line| line.done()).map(|figures| figures.maps.len()).max();
    match count {
        Some(count) if count > 1 => format!("mean of {count} maps; bars: worst to best"),
        _ => String::new(),
    }
}

/// Several models in columns: PSNR above, what that is against plain resampling below. Those without a curve are left out.
pub fn several(records: &[&Tradeoff]) -> String {
    const TOP: f64 = 262.0;
    const HEIGHTS: [f64; 2] = [300.0, 210.0];
    const BETWEEN: f64 = 84.0;
    let curves: Vec<(&str, &Curve)> =
        records.iter().filter_map(|record| Some((record.model.as_str(), record.curve.as_ref()?))).collect();
    let height = TOP + HEIGHTS[0] + BETWEEN + HEIGHTS[1] + 66.0;
    let words = "Texels against error: what a budget buys";
    let mut svg = Svg::new(WIDTH, height, words);
    svg.text([MARGIN, 62.0], HEADLINE, words);
    let subtitle = "Texels of level 0 of one map, as they are allocated. Plain resampling: the source, once, bilinearly, to as many.";
    svg.text([MARGIN, 100.0], SUBTITLE, subtitle);
    if let Some((_, first)) = curves.first() {
        draw_legend(&mut svg, first, [MARGIN, 146.0]);
    }
    let gap = 30.0;
    let count = curves.len().max(1) as f64;
    let width = (WIDTH - 2.0 * MARGIN - gap * (count - 1.0)) / count;
    for (number, (model, curve)) in curves.iter().enumerate() {
        let left = MARGIN + (width + gap) * number as f64;
        svg.text([left, TOP - 16.0], TITLE, model);
        let below = TOP + HEIGHTS[0] + BETWEEN;
        if number == 0 {
            svg.text([left, TOP - 56.0], NOTE, "Base color: PSNR, dB");
            let note =
                "Against plain resampling, dB: the mean of all maps; bars: from the worst map to the best";
            svg.text([left, below - 16.0], NOTE, note);
        }
        for (kind, top, height) in [(Kind::Psnr, TOP, HEIGHTS[0]), (Kind::Gain, below, HEIGHTS[1])] {
            let panel = Panel { curve, kind, place: [left, top, width, height], tick_counts: [3, 5] };
            curve_panel::draw(&mut svg, &panel);
        }
    }
    svg.finish()
}

/// The lines' names in a row, each behind a piece of its line.
fn draw_legend(svg: &mut Svg, curve: &Curve, [left, baseline]: [f64; 2]) {
    let mut x = left;
    let names = curve.lines.iter().map(|line| line.name.as_str()).chain([curve_panel::PLAIN]);
    for (number, name) in names.enumerate() {
        let (ink, width) = if name == curve_panel::PLAIN { curve_panel::PLAIN_STROKE } else { inks(number) };
        let middle = baseline - 7.0;
        svg.line(&[[x, middle], [x + 38.0, middle]], width, ink);
        if name != curve_panel::PLAIN {
            svg.disk([x + 19.0, middle], 2.0 + 1.5 * width, ink);
        }
        let ink = if name == curve_panel::PLAIN { ink::MUTED } else { ink };
        svg.text([x + 50.0, baseline], Style::new(LEGEND, ink), name);
        x += 50.0 + text_width(name, LEGEND) + 44.0;
    }
}
