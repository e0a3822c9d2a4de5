//! Error against time: a point for each run, the presets large, the Pareto front as a stair.

use super::super::plan::HOME;
use super::super::record::{Done, Run, Tradeoff};
use super::super::words::{figure, seam, time};
use super::{preset_ink, presets_of, unit};
use crate::plot::{Anchor, Axis, Style, Svg, ink, text_width};

/// What one panel shows.
pub struct Panel {
    pub title: &'static str,
    pub error: fn(&Done) -> Option<f64>,
    pub is_on_front: fn(&Done) -> bool,
    /// Whether the time axis has its name below.
    pub has_time_words: bool,
}

/// A run in the panel.
struct Point<'a> {
    at: [f64; 2],
    seconds: f64,
    error: f64,
    run: &'a Run,
    preset: Option<&'a str>,
    is_on_front: bool,
    /// The largest seam, of a run that leaves any.
    seam: Option<f64>,
}

const TITLE: Style = Style::new(24.0, ink::TEXT).strong();
const TICK: Style = Style::new(19.0, ink::MUTED);
const NAME_SIZE: f64 = 25.0;
const FIGURES: Style = Style::new(20.0, ink::TEXT);
const RUNG: Style = Style::new(18.0, ink::MUTED);
/// The ground above the front.
const BEATEN: &str = "#23272c";
/// Room for the error axis's figures.
const AXIS_WIDTH: f64 = 58.0;

/// Draws into `[left, top, width, height]`.
pub fn draw(svg: &mut Svg, record: &Tradeoff, panel: &Panel, place: [f64; 4]) {
    let [left, top, width, height] = place;
    svg.text([left, top - 14.0], TITLE, panel.title);
    let title_end = left + text_width(panel.title, TITLE.size) + 14.0;
    svg.text([title_end, top - 14.0], TICK, &format!("RMS, {}; lower is nearer", unit(record)));
    let plot = [left + AXIS_WIDTH, top, width - AXIS_WIDTH, height - 36.0];
    svg.rectangle(plot, 6.0, ink::PANEL);
    let dones = || record.runs.iter().filter_map(Run::done);
    let seconds = dones().map(|done| done.cost.converting_cpu_seconds);
    let across = Axis::log(seconds, 1.35, [plot[0], plot[0] + plot[2]]);
    let up = Axis::linear(dones().filter_map(panel.error), [plot[1] + plot[3], plot[1]]);
    draw_axes(svg, (&across, &up), plot, panel.has_time_words);
    let points = points(record, panel, (&across, &up));
    let stair = draw_front(svg, &points, plot);
    draw_points(svg, &points);
    let taken = draw_labels(svg, &points, &stair, (plot, unit(record)));
    if let Some(end) = stair.last() {
        name_front(svg, end[1], plot, &taken);
    }
}

fn draw_axes(svg: &mut Svg, (across, up): (&Axis, &Axis), plot: [f64; 4], has_time_words: bool) {
    let [left, top, width, height] = plot;
    let bottom = top + height;
    for tick in up.ticks(4) {
        let y = up.at(tick);
        svg.line(&[[left, y], [left + width, y]], 1.0, ink::GRID);
        svg.text([left - 10.0, y + 6.5], TICK.anchored(Anchor::End), &short(tick));
    }
    for tick in across.ticks(3) {
        let x = across.at(tick);
        svg.line(&[[x, top], [x, bottom]], 1.0, ink::GRID);
        let is_inside = x > left + 20.0 && x < left + width - 20.0;
        if is_inside {
            svg.text([x, bottom + 25.0], TICK.anchored(Anchor::Middle), &axis_time(tick));
        }
    }
    if has_time_words {
        let style = TICK.anchored(Anchor::End);
        svg.text(
            [left + width, bottom + 50.0],
            style,
            "computing: CPU seconds without reading, measuring, writing",
        );
    }
}

/// Without needless zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn axis_time(seconds: f64) -> String {
    if seconds < 0.0995 { format!("{} ms", short(seconds * 1000.0)) } else { format!("{} s", short(seconds)) }
}

fn points<'a>(record: &'a Tradeoff, panel: &Panel, (across, up): (&Axis, &Axis)) -> Vec<Point<'a>> {
    let point = |run: &'a Run| {
        let done = run.done()?;
        let (seconds, error) = (done.cost.converting_cpu_seconds, (panel.error)(done)?);
        Some(Point {
            at: [across.at(seconds), up.at(error)],
            seconds,
            error,
            run,
            preset: presets_of(record, run).next(),
            is_on_front: (panel.is_on_front)(done),
            seam: (!done.is_seamless).then(|| seam(done)),
        })
    };
    record.runs.iter().filter_map(point).collect()
}

/// The stair that no run is below; returns its corners.
fn draw_front(svg: &mut Svg, points: &[Point<'_>], plot: [f64; 4]) -> Vec<[f64; 2]> {
    let [left, top, width, _] = plot;
    let right = left + width;
    let mut front: Vec<[f64; 2]> =
        points.iter().filter(|point| point.is_on_front).map(|point| point.at).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (Some(first), Some(last)) = (front.first(), front.last()) else { return front };
    let mut stair = vec![*first];
    for pair in front.windows(2) {
        stair.extend([[pair[1][0], pair[0][1]], pair[1]]);
    }
    stair.push([right, last[1]]);
    let corners = [[right, top], [first[0], top]];
    svg.area(&[&stair[..], &corners].concat(), BEATEN);
    svg.line(&stair, 2.5, ink::FAINT);
    stair
}

/// Boxes around the lines of a stair.
fn boxes_of(stair: &[[f64; 2]]) -> impl Iterator<Item = [f64; 4]> {
    stair.windows(2).map(|pair| {
        let [a, b] = [pair[0], pair[1]];
        [a[0].min(b[0]) - 2.0, a[1].min(b[1]) - 2.0, a[0].max(b[0]) + 2.0, a[1].max(b[1]) + 2.0]
    })
}

/// Names the front at its right end, where there is room.
fn name_front(svg: &mut Svg, end: f64, plot: [f64; 4], taken: &[[f64; 4]]) {
    const WORDS: &str = "Pareto front";
    let [left, top, width, height] = plot;
    let size = [text_width(WORDS, RUNG.size), RUNG.size];
    for (right, y) in [(12.0, end + 6.0), (12.0, end - 6.0 - size[1]), (220.0, end + 6.0), (12.0, top + 10.0)]
    {
        let place = [left + width - right - size[0], y, left + width - right, y + size[1]];
        if y + size[1] < top + height && !taken.iter().any(|other| meet(place, *other)) {
            svg.text([place[0], place[3] - 3.0], RUNG, WORDS);
            return;
        }
    }
}

fn draw_points(svg: &mut Svg, points: &[Point<'_>]) {
    let (presets, rungs): (Vec<_>, Vec<_>) = points.iter().partition(|point| point.preset.is_some());
    // The home of all rungs lies on top.
    let home_last = |point: &&&Point<'_>| point.preset == Some(HOME);
    let others = presets.iter().filter(|point| !home_last(point));
    for point in rungs.iter().chain(others).chain(presets.iter().filter(home_last)) {
        let (radius, ink) = match point.preset {
            Some(preset) => (if preset == HOME { 15.0 } else { 13.0 }, preset_ink(preset)),
            None if point.is_on_front => (8.0, ink::TEXT),
            None => (7.0, ink::FAINT),
        };
        if point.seam.is_some() {
            svg.ring(point.at, radius, ink);
        } else {
            svg.disk(point.at, radius, ink);
        }
    }
}

/// A label's lines, each with its style.
type Lines = Vec<(String, Style)>;

/// Presets have their labels in any case; rungs where there is room, those of the front first. Returns the
/// places that are taken.
fn draw_labels(
    svg: &mut Svg,
    points: &[Point<'_>],
    stair: &[[f64; 2]],
    (plot, unit): ([f64; 4], &str),
) -> Vec<[f64; 4]> {
    let radius = |point: &Point<'_>| if point.preset.is_some() { 15.0 } else { 8.0 };
    let disk = |point: &Point<'_>| {
        let ([x, y], r) = (point.at, radius(point));
        [x - r, y - r, x + r, y + r]
    };
    let mut order: Vec<&Point<'_>> = points.iter().collect();
    order.sort_by_key(|point| (point.preset.is_none(), !point.is_on_front));
    let lines: Vec<[f64; 4]> = boxes_of(stair).collect();
    let mut taken: Vec<[f64; 4]> = order.iter().map(|point| disk(point)).collect();
    for point in order {
        let words = words_of(point, unit);
        let width = words.iter().map(|(words, style)| text_width(words, style.size)).fold(0.0, f64::max);
        let height: f64 = words.iter().map(|(_, style)| style.size * 1.12).sum();
        let mut places = places(point.at, radius(point), [width, height]);
        places.retain(|place| is_inside(*place, plot));
        let covered =
            |place: &[f64; 4], boxes: &[[f64; 4]]| boxes.iter().filter(|other| meet(*place, **other)).count();
        let is_free = |place: &&[f64; 4]| covered(place, &taken) + covered(place, &lines) == 0;
        let found = places.iter().find(is_free);
        let least = || places.iter().min_by_key(|place| 2 * covered(place, &taken) + covered(place, &lines));
        let Some(place) = found.or_else(|| point.preset.and_then(|_| least())).copied() else { continue };
        taken.push(place);
        let mut baseline = place[1];
        for (words, style) in &words {
            baseline += style.size * 1.12;
            svg.text_on_lines([place[0], baseline - style.size * 0.25], *style, words);
        }
    }
    taken
}

fn words_of(point: &Point<'_>, unit: &str) -> Lines {
    let Some(preset) = point.preset else { return vec![(point.run.name.clone(), RUNG)] };
    let mut lines = vec![
        (preset.to_owned(), Style::new(NAME_SIZE, preset_ink(preset)).strong()),
        (format!("{} · {} {unit}", time(point.seconds), figure(point.error)), FIGURES),
    ];
    if let Some(seam) = point.seam {
        lines.push((format!("leaves seams of {} {unit}", figure(seam)), RUNG));
    }
    lines
}

/// Where a label may stand around its point, best first: boxes of left, top, right, bottom.
fn places([x, y]: [f64; 2], radius: f64, [width, height]: [f64; 2]) -> Vec<[f64; 4]> {
    let away = radius + 7.0;
    let corners = [
        [x + away, y - height / 2.0],
        [x - away - width, y - height / 2.0],
        [x - width / 2.0, y - away - height],
        [x - width / 2.0, y + away],
        [x + away * 0.7, y - away * 0.7 - height],
        [x + away * 0.7, y + away * 0.7],
        [x - away * 0.7 - width, y - away * 0.7 - height],
        [x - away * 0.7 - width, y + away * 0.7],
    ];
    corners.map(|[left, top]| [left, top, left + width, top + height]).to_vec()
}

fn is_inside(place: [f64; 4], [left, top, width, height]: [f64; 4]) -> bool {
    place[0] >= left + 4.0
        && place[1] >= top + 2.0
        && place[2] <= left + width - 4.0
        && place[3] <= top + height - 2.0
}

fn meet(a: [f64; 4], b: [f64; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}
