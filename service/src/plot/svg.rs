//! Writes SVG: text, lines, circles, rectangles.

use std::fmt::Write;

use super::ink;

/// Where a text's place is in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// How words look.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Height of the letters' square, pixels.
    pub size: f64,
    pub ink: &'static str,
    /// Width of the outlines, in sizes: the font is a light one, and where words matter these are drawn too.
    pub outline: f64,
    pub anchor: Anchor,
}

impl Style {
    pub const fn new(size: f64, ink: &'static str) -> Self {
        Self { size, ink, outline: 0.0, anchor: Anchor::Start }
    }

    pub const fn strong(self) -> Self {
        Self { outline: 1.0 / 28.0, ..self }
    }

    pub const fn anchored(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }
}

/// A picture that grows.
pub struct Svg {
    width: f64,
    height: f64,
    body: String,
}

impl Svg {
    /// An empty page of pixels; `title` is what a screen reader says.
    pub fn new(width: f64, height: f64, title: &str) -> Self {
        let mut svg = Self { width, height, body: String::new() };
        svg.element(format_args!("<title>{}</title>", escape(title)));
        svg.rectangle([0.0, 0.0, width, height], 0.0, ink::BACKGROUND);
        svg
    }

    /// Words whose baseline is at `at`.
    pub fn text(&mut self, at: [f64; 2], style: Style, words: &str) {
        let anchor = match style.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let stroke = if style.outline > 0.0 {
            format!(" stroke=\"{}\" stroke-width=\"{}\"", style.ink, number(style.size * style.outline))
        } else {
            String::new()
        };
        let ([x, y], size, words) = (at.map(number), number(style.size), escape(words));
        let ink = style.ink;
        self.element(format_args!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" fill=\"{ink}\"{stroke}{anchor}>{words}</text>"
        ));
    }

    /// Words on a panel that may stand on lines: a rim keeps these off.
    pub fn text_on_lines(&mut self, at: [f64; 2], style: Style, words: &str) {
        self.text(at, Style { ink: ink::PANEL, outline: 0.3, ..style }, words);
        self.text(at, style, words);
    }

    /// A line through points.
    pub fn line(&mut self, points: &[[f64; 2]], width: f64, ink: &str) {
        let points = list(points);
        self.element(format_args!(
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"{}\" stroke-linejoin=\"round\"/>",
            number(width)
        ));
    }

    /// A closed area.
    pub fn area(&mut self, points: &[[f64; 2]], ink: &str) {
        self.element(format_args!("<polygon points=\"{}\" fill=\"{ink}\"/>", list(points)));
    }

    /// `[x, y, width, height]`, with rounded corners.
    pub fn rectangle(&mut self, place: [f64; 4], radius: f64, ink: &str) {
        let [x, y, width, height] = place.map(number);
        self.element(format_args!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"{}\" fill=\"{ink}\"/>",
            number(radius)
        ));
    }

    /// A disk with a ring of the background around it, so that neighbors stay apart.
    pub fn disk(&mut self, at: [f64; 2], radius: f64, ink: &str) {
        let [x, y] = at.map(number);
        self.element(format_args!(
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"{}\" fill=\"{ink}\" stroke=\"{}\" stroke-width=\"2\"/>",
            number(radius),
            ink::PANEL
        ));
    }

    /// A disk with a hole.
    pub fn ring(&mut self, at: [f64; 2], radius: f64, ink: &str) {
        let [x, y] = at.map(number);
        let radius = number(radius - 1.5);
        self.element(format_args!(
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{}\" stroke=\"{ink}\" stroke-width=\"3\"/>",
            ink::PANEL
        ));
    }

    /// The whole document.
    pub fn finish(self) -> String {
        let (width, height) = (number(self.width), number(self.height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"Ubuntu, sans-serif\" font-weight=\"300\">\n{}</svg>\n",
            self.body
        )
    }

    fn element(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.body, "{element}");
    }
}

/// About how wide words are in pixels, from the font's own proportions.
pub fn text_width(words: &str, size: f64) -> f64 {
    let ems = words.chars().map(|c| match c {
        'i' | 'j' | 'l' | '.' | ',' | ':' | '\'' | '|' | '·' => 0.25,
        ' ' | 'f' | 't' | 'r' | '-' | '(' | ')' | '/' => 0.36,
        'm' | 'w' | 'M' | 'W' | '%' => 0.84,
        'A'..='Z' => 0.66,
        _ => 0.56,
    });
    ems.sum::<f64>() * size
}

/// To a tenth, without a needless zero.
fn number(value: f64) -> String {
    let text = format!("{value:.1}");
    let text = text.strip_suffix(".0").unwrap_or(&text);
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn list(points: &[[f64; 2]]) -> String {
    let pairs = points.iter().map(|[x, y]| format!("{},{}", number(*x), number(*y)));
    pairs.collect::<Vec<_>>().join(" ")
}

/// Text as XML holds it; control characters, which it cannot hold, are left out.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars().filter(|c| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}')) {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_cannot_leave_their_element() {
        let mut svg = Svg::new(10.0, 10.0, "a<b");
        svg.text([1.0, 2.26], Style::new(3.0, ink::TEXT), "\"</text>&\u{1}");
        let text = svg.finish();
        assert!(text.contains("y=\"2.3\""), "{text}");
        assert!(text.contains(">&quot;&lt;/text&gt;&amp;</text>"), "{text}");
    }

    #[test]
    fn numbers_are_short_and_never_minus_zero() {
        assert_eq!([-0.04, 2.0, 2.25, 10.06].map(number), ["0", "2", "2.2", "10.1"]);
    }
}
