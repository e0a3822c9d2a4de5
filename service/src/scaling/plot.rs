//! The picture: time by stage, time by rung and memory against the number of faces, all logarithmic, with
//! n log n as a yardstick.

use super::{Scaling, Series};
use crate::plot::{Anchor, Axis, Style, Svg, ink, text_width};
use crate::tradeoff::HOME;

const WIDTH: f64 = 1600.0;
const HEIGHT: f64 = 800.0;
const MARGIN: f64 = 52.0;
const TOP: f64 = 196.0;
const BOTTOM: f64 = 736.0;
const HEADLINE: Style = Style::new(33.0, ink::TEXT).strong();
const SUBTITLE: Style = Style::new(21.0, ink::MUTED);
const TITLE: Style = Style::new(24.0, ink::TEXT).strong();
const TICK: Style = Style::new(19.0, ink::MUTED);
const LABEL_SIZE: f64 = 19.0;
/// Room for the labels at the lines' ends.
const LABEL_WIDTH: f64 = 204.0;
const AXIS_WIDTH: f64 = 66.0;
/// Closest distance of two labels.
const LABEL_STEP: f64 = 21.0;

/// One panel: what it shows and where.
struct Panel<'a> {
    title: &'a str,
    /// How a value is written at the axis.
    shown: fn(f64) -> String,
    series: Vec<Series>,
    place: [f64; 4],
}

/// The picture as SVG, the same bytes for the same record.
pub fn svg(scaling: &Scaling) -> String {
    let words = headline(scaling);
    let mut svg = Svg::new(WIDTH, HEIGHT, &words);
    svg.text([MARGIN, 62.0], HEADLINE, &words);
    let subtitle = "A torus in finer and finer grids, as much texture on each face at every size. CPU seconds of all threads.";
    svg.text([MARGIN, 100.0], SUBTITLE, subtitle);
    let gap = 20.0;
    let width = (WIDTH - 2.0 * MARGIN - 2.0 * gap) / 3.0;
    let place = |number: f64| [MARGIN + (width + gap) * number, TOP, width, BOTTOM - TOP];
    let panels = [
        Panel { title: "Stages of standard", shown: seconds, series: scaling.stages(), place: place(0.0) },
        Panel { title: "Presets and rungs", shown: seconds, series: scaling.runs(), place: place(1.0) },
        Panel {
            title: "Peak memory of standard",
            shown: memory,
            series: vec![scaling.memory()],
            place: place(2.0),
        },
    ];
    for panel in &panels {
        draw(&mut svg, panel);
    }
    svg.finish()
}

/// The largest size, its time, and the exponent.
fn headline(scaling: &Scaling) -> String {
    let runs = scaling.runs();
    let home = runs.iter().find(|series| series.name == HOME);
    let Some((series, (faces, value))) = home.and_then(|series| Some((series, *series.points.last()?)))
    else {
        return "Nothing was measured".to_owned();
    };
    let growth = series.exponent().map_or_else(String::new, |e| format!(": time grows like n to the {e:.2}"));
    format!("{} faces in {} of computing{growth}", count(faces), seconds(value))
}

fn draw(svg: &mut Svg, panel: &Panel<'_>) {
    let [left, top, width, height] = panel.place;
    svg.text([left, top - 16.0], TITLE, panel.title);
    let plot = [left + AXIS_WIDTH, top, width - AXIS_WIDTH - LABEL_WIDTH, height];
    svg.rectangle(plot, 6.0, ink::PANEL);
    let all = || panel.series.iter().flat_map(|series| &series.points);
    let across = Axis::log(all().map(|point| point.0), 1.15, [plot[0], plot[0] + plot[2]]);
    let up = Axis::log(all().map(|point| point.1), 1.5, [plot[1] + height, plot[1]]);
    for tick in up.ticks(3) {
        svg.line(&[[plot[0], up.at(tick)], [plot[0] + plot[2], up.at(tick)]], 1.0, ink::GRID);
        svg.text([plot[0] - 10.0, up.at(tick) + 6.5], TICK.anchored(Anchor::End), &(panel.shown)(tick));
    }
    for tick in across.ticks(3) {
        svg.line(&[[across.at(tick), top], [across.at(tick), top + height]], 1.0, ink::GRID);
        svg.text([across.at(tick), top + height + 26.0], TICK.anchored(Anchor::Middle), &count(tick));
    }
    draw_yardstick(svg, panel, (&across, &up));
    let mut labels = Vec::new();
    for series in &panel.series {
        let points: Vec<_> = series.points.iter().map(|point| [across.at(point.0), up.at(point.1)]).collect();
        let is_home = series.name == HOME || panel.series.len() == 1;
        let (line_width, color) = if is_home { (4.0, ink::AMBER) } else { (2.0, ink::MUTED) };
        svg.line(&points, line_width, color);
        if let Some(end) = points.last() {
            labels.push(([end[0], end[1]], series, if is_home { ink::AMBER } else { ink::TEXT }));
        }
    }
    labels.sort_by(|a, b| a.0[1].total_cmp(&b.0[1]));
    // Pushed down where they would meet, then the whole column up where it would leave the panel.
    let mut heights: Vec<f64> = Vec::new();
    for (end, ..) in &labels {
        let next = heights.last().map_or(f64::MIN, |last| last + LABEL_STEP);
        heights.push(end[1].max(next));
    }
    let over = heights.last().map_or(0.0, |last| (last - (top + height - 4.0)).max(0.0));
    for ((_, series, color), height) in labels.iter().zip(&heights) {
        let exponent = series.exponent().map_or_else(String::new, |e| format!("{e:.2}"));
        let x = plot[0] + plot[2] + 10.0;
        svg.text([x, height - over + 6.0], Style::new(LABEL_SIZE, color), &series.name);
        let after = x + text_width(&series.name, LABEL_SIZE) + 9.0;
        svg.text([after, height - over + 6.0], Style::new(LABEL_SIZE, ink::MUTED), &exponent);
    }
}

/// What n log n would be, through the end of the largest series.
fn draw_yardstick(svg: &mut Svg, panel: &Panel<'_>, (across, up): (&Axis, &Axis)) {
    let largest = panel.series.iter().max_by(|a, b| {
        let end = |series: &Series| series.points.last().map_or(0.0, |point| point.1);
        end(a).total_cmp(&end(b))
    });
    let Some(points) = largest.map(|series| &series.points) else { return };
    let Some(last) = points.last() else { return };
    let law = |n: f64| n * n.log2();
    let scale = last.1 / law(last.0);
    // A straight line on these axes, or nearly; as far as the panel goes.
    let line = points.iter().map(|point| [across.at(point.0), up.at(scale * law(point.0))]);
    let line: Vec<_> = line.filter(|at| at[1] <= BOTTOM).collect();
    svg.line(&line, 7.0, "#2f353c");
    if let [start, _, ..] = line[..] {
        svg.text([start[0] + 14.0, start[1] + 4.0], Style::new(17.0, ink::FAINT), "n log n");
    }
}

fn count(value: f64) -> String {
    match value {
        v if v >= 999_500.0 => format!("{} M", (v / 1e5).round() / 10.0),
        v if v >= 999.5 => format!("{} k", (v / 100.0).round() / 10.0),
        v => format!("{v:.0}"),
    }
}

fn seconds(value: f64) -> String {
    match value {
        v if v >= 9.95 => format!("{v:.0} s"),
        v if v >= 0.95 => format!("{} s", (v * 10.0).round() / 10.0),
        v if v >= 0.00095 => format!("{} ms", (v * 1e4).round() / 10.0),
        v => format!("{:.0} µs", v * 1e6),
    }
}

fn memory(value: f64) -> String {
    if value >= 1023.5 {
        format!("{} GiB", (value / 102.4).round() / 10.0)
    } else {
        format!("{value:.0} MiB")
    }
}
