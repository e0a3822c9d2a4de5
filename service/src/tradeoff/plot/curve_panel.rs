//! One panel of a curve: texels across, decibels up.

use super::super::curve::{Curve, FLOOR_TEXELS, Figures, Line};
use super::super::words::{short_count, signed};
use crate::plot::{Anchor, Axis, Style, Svg, ink, text_width};

/// The yardstick's name.
pub const PLAIN: &str = "plain resampling";
pub const PLAIN_STROKE: (&str, f64) = ("#7d848c", 3.0);
/// Where faces are down to their corners.
const FLOOR: &str = "#2a2422";
const TICK: Style = Style::new(19.0, ink::MUTED);
const MARK: Style = Style::new(17.0, ink::MUTED);
/// Room for the figures of the axis upwards.
const AXIS_WIDTH: f64 = 52.0;

/// What is drawn upwards.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Decibels of base color, of the runs and of the yardstick.
    Psnr,
    /// Decibels over the yardstick, the mean over all maps.
    Gain,
}

pub struct Panel<'a> {
    pub curve: &'a Curve,
    pub kind: Kind,
    /// Left, top, width, height; the figures across stand below.
    pub place: [f64; 4],
    /// Figures across and up, about.
    pub tick_counts: [usize; 2],
}

/// Color and width of a line by its place in the curve.
pub fn inks(number: usize) -> (&'static str, f64) {
    match number {
        0 => (ink::AMBER, 4.0),
        1 => (ink::CORAL, 2.5),
        _ => (ink::TEAL, 2.5),
    }
}

fn value(kind: Kind, figures: &Figures) -> Option<f64> {
    match kind {
        Kind::Psnr => figures.color_psnr_db().map(|[ours, _]| ours),
        Kind::Gain => figures.gains_db().map(|[mean, ..]| mean),
    }
}

pub fn draw(svg: &mut Svg, panel: &Panel<'_>) {
    let [left, top, width, height] = panel.place;
    let plot = [left + AXIS_WIDTH, top, width - AXIS_WIDTH, height];
    svg.rectangle(plot, 6.0, ink::PANEL);
    let all = || panel.curve.lines.iter().flat_map(Line::done);
    let texels = || all().map(|figures| figures.texels as f64);
    // The source's own size tells something as long as it is near.
    let most = texels().fold(0.0, f64::max);
    let source = panel.curve.source_texels.map(|texels| texels as f64).filter(|texels| *texels <= 4.0 * most);
    let across = Axis::log(texels().chain(source), 1.35, [plot[0], plot[0] + plot[2]]);
    let ours = all().filter_map(|figures| value(panel.kind, figures));
    let beside = all().flat_map(|figures| match panel.kind {
        Kind::Psnr => figures.color_psnr_db().map(|[_, plain]| [plain; 2]),
        Kind::Gain => figures.gains_db().map(|[_, least, most]| [least.min(0.0), most.max(0.0)]),
    });
    let up = Axis::linear(ours.chain(beside.flatten()), [plot[1] + plot[3], plot[1]]);
    let axes = (&across, &up);
    draw_floor(svg, panel, &across, plot);
    draw_axes(svg, panel, axes, plot);
    draw_source(svg, panel, &across, plot);
    draw_plain(svg, panel, axes, plot);
    for (number, line) in panel.curve.lines.iter().enumerate().rev() {
        draw_line(svg, panel.kind, (number, line), axes);
    }
}

fn draw_axes(svg: &mut Svg, panel: &Panel<'_>, (across, up): (&Axis, &Axis), plot: [f64; 4]) {
    let [left, top, width, height] = plot;
    for tick in up.ticks(panel.tick_counts[1]) {
        let y = up.at(tick);
        svg.line(&[[left, y], [left + width, y]], 1.0, ink::GRID);
        let words = if panel.kind == Kind::Gain { signed(tick) } else { format!("{tick:.0}") };
        let words =
            words.strip_suffix(".0").filter(|words| *words != "0").unwrap_or(words.trim_end_matches(".0"));
        svg.text([left - 10.0, y + 6.5], TICK.anchored(Anchor::End), words);
    }
    let ticks = across.ticks(panel.tick_counts[0]);
    for tick in ticks {
        let x = across.at(tick);
        svg.line(&[[x, top], [x, top + height]], 1.0, ink::GRID);
        if x > left + 14.0 && x < left + width - 14.0 {
            svg.text([x, top + height + 26.0], TICK.anchored(Anchor::Middle), &short_count(tick));
        }
    }
}

/// Where the average face has no more than its corners: nothing is coarser than that.
fn draw_floor(svg: &mut Svg, panel: &Panel<'_>, across: &Axis, [left, top, width, height]: [f64; 4]) {
    let end = across.at((FLOOR_TEXELS * panel.curve.stored_face_count) as f64).min(left + width);
    if end > left + 6.0 {
        svg.rectangle([left, top, end - left, height], 0.0, FLOOR);
        if panel.kind == Kind::Psnr {
            svg.text([left + 8.0, top + height - 10.0], MARK, "≤ 4 a face");
        }
    }
}

/// The source's own number of texels.
fn draw_source(svg: &mut Svg, panel: &Panel<'_>, across: &Axis, [left, top, width, height]: [f64; 4]) {
    let Some(texels) = panel.curve.source_texels else { return };
    let x = across.at(texels as f64);
    if x < left + 8.0 || x > left + width - 8.0 {
        return;
    }
    let mut y = top + 30.0;
    while y < top + height {
        svg.line(&[[x, y], [x, (y + 5.0).min(top + height)]], 1.5, ink::FAINT);
        y += 11.0;
    }
    const WORD: &str = "source";
    let half = text_width(WORD, MARK.size) / 2.0 + 6.0;
    let middle = x.clamp(left + half, left + width - half);
    svg.text([middle, top + 22.0], MARK.anchored(Anchor::Middle), WORD);
}

/// The yardstick: a curve of its own against texels, and zero against itself.
fn draw_plain(svg: &mut Svg, panel: &Panel<'_>, (across, up): (&Axis, &Axis), plot: [f64; 4]) {
    let (ink, width) = PLAIN_STROKE;
    if panel.kind == Kind::Gain {
        svg.line(&[[plot[0], up.at(0.0)], [plot[0] + plot[2], up.at(0.0)]], width, ink);
        return;
    }
    let done = panel.curve.lines.iter().flat_map(Line::done);
    let mut points: Vec<(u64, f64)> =
        done.filter_map(|figures| Some((figures.texels, figures.color_psnr_db()?[1]))).collect();
    points.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let points: Vec<_> = points.iter().map(|&(texels, db)| [across.at(texels as f64), up.at(db)]).collect();
    svg.line(&points, width, ink);
}

fn draw_line(svg: &mut Svg, kind: Kind, (number, line): (usize, &Line), (across, up): (&Axis, &Axis)) {
    let (ink, width) = inks(number);
    let at = |figures: &Figures| Some([across.at(figures.texels as f64), up.at(value(kind, figures)?)]);
    let points: Vec<_> = line.done().filter_map(at).collect();
    if kind == Kind::Gain && number == 0 {
        for figures in line.done().filter(|figures| figures.maps.len() > 1) {
            let Some([_, least, most]) = figures.gains_db() else { continue };
            let x = across.at(figures.texels as f64);
            svg.line(&[[x, up.at(least)], [x, up.at(most)]], 7.0, "#5c4a2c");
        }
    }
    svg.line(&points, width, ink);
    for point in points {
        svg.disk(point, 2.0 + 1.5 * width, ink);
    }
}
