//! The sheet: a heading, three columns, a row of pictures for each view and level.

mod canvas;
mod text;

use self::canvas::{Area, Canvas, Ink, Points};
use self::text::{Style, Typeface};
use super::PreviewError;
use super::picture::{Picture, differences};

/// What the sheet says and shows.
pub struct Page {
    pub title: String,
    pub subtitle: String,
    pub renderer: String,
    /// What the source's column shows.
    pub source: &'static str,
    pub rows: Vec<Row>,
    /// What the reader must know about what is not shown; one line each.
    pub notes: Vec<String>,
}

pub struct Row {
    pub title: String,
    pub detail: String,
    pub source: Picture,
    pub converted: Picture,
    pub arrows: Arrows,
}

/// Small arrowheads outside of the pictures that point to the seam; pixels of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrows {
    None,
    /// Above and below: the seam runs from one to the other.
    Line {
        x: f32,
    },
    /// Above and to the left: the seam lies where their ways cross.
    Place {
        x: f32,
        y: f32,
    },
}

/// The difference column shows codes times this.
pub const AMPLIFICATION: u32 = 4;

const WIDTH: u32 = 1600;
const MARGIN: u32 = 48;
const GAP: u32 = 23;
const HEADING: u32 = 156;
const CAPTION: u32 = 46;
const ROW_GAP: u32 = 30;
const NOTE: u32 = 26;
const FOOT: u32 = 44;

const PAPER: Ink = Ink([20, 21, 23]);
const RULE: Ink = Ink([52, 54, 59]);
const STRONG: Ink = Ink([236, 233, 226]);
const SOFT: Ink = Ink([158, 160, 166]);
const ACCENT: Ink = Ink([226, 165, 74]);

const TITLE: Style = Style { height: 38.0, spacing: 0.0, ink: STRONG };
const BODY: Style = Style { height: 17.5, spacing: 0.2, ink: SOFT };
const LABEL: Style = Style { height: 20.0, spacing: 0.2, ink: STRONG };
const COLUMN: Style = Style { height: 17.0, spacing: 2.0, ink: STRONG };

/// # Errors
/// `Font` and `Encode`: faults of this program.
pub fn png(page: &Page) -> Result<Vec<u8>, PreviewError> {
    let typeface = Typeface::new()?;
    let rows: u32 = page.rows.iter().map(|row| CAPTION + row.source.size[1] + ROW_GAP).sum();
    let notes = NOTE * page.notes.len() as u32;
    let mut canvas = Canvas::new([WIDTH, HEADING + rows - ROW_GAP.min(rows) + notes + FOOT], PAPER);
    let mut sheet = Sheet { canvas: &mut canvas, typeface: &typeface };
    sheet.heading(page);
    let mut top = HEADING;
    for row in &page.rows {
        sheet.row(row, top);
        top += CAPTION + row.source.size[1] + ROW_GAP;
    }
    for note in &page.notes {
        sheet.words([MARGIN, top + 6], &sheet.typeface.fitted(note, (WIDTH - 2 * MARGIN) as f32, BODY), BODY);
        top += NOTE;
    }
    canvas.png()
}

struct Sheet<'a> {
    canvas: &'a mut Canvas,
    typeface: &'a Typeface,
}

fn column_left(column: u32) -> u32 {
    let width = (WIDTH - 2 * MARGIN - 2 * GAP) / 3;
    MARGIN + column * (width + GAP)
}

impl Sheet<'_> {
    /// Returns where the words end.
    fn words(&mut self, at: [u32; 2], words: &str, style: Style) -> u32 {
        self.typeface.draw(self.canvas, at.map(|v| v as f32), words, style).ceil() as u32
    }

    fn words_right(&mut self, at: [u32; 2], words: &str, style: Style) {
        self.typeface.draw_right(self.canvas, at.map(|v| v as f32), words, style);
    }

    fn heading(&mut self, page: &Page) {
        let right = WIDTH - MARGIN;
        let renderer_width = self.typeface.width(&page.renderer, BODY);
        let subtitle_width = self.typeface.width(&page.subtitle, BODY);
        let title = self.typeface.fitted(&page.title, (right - MARGIN) as f32, TITLE);
        self.words([MARGIN, 62], &title, TITLE);
        let free = (right - MARGIN) as f32 - subtitle_width - 40.0;
        let renderer = if renderer_width <= free {
            page.renderer.clone()
        } else {
            self.typeface.fitted(&page.renderer, free, BODY)
        };
        self.words([MARGIN, 91], &page.subtitle, BODY);
        self.words_right([right, 91], &renderer, BODY);
        self.canvas.fill(Area { left: MARGIN, top: 108, width: right - MARGIN, height: 1 }, RULE);
        let columns = [
            ("SOURCE", page.source),
            ("CONVERTED", "mesh color texture"),
            ("DIFFERENCE ×4", "largest component"),
        ];
        for (column, (name, detail)) in columns.into_iter().enumerate() {
            let end = self.words([column_left(column as u32), 140], name, COLUMN);
            self.words([end + 12, 140], detail, BODY);
        }
        self.scale(right);
    }

    /// What the grays of the difference column mean.
    fn scale(&mut self, right: u32) {
        const BAR: u32 = 88;
        let end = format!("{}+ codes", 256 / AMPLIFICATION);
        let end_width = self.typeface.width(&end, BODY).ceil() as u32;
        self.words_right([right, 140], &end, BODY);
        let left = right - end_width - 8 - BAR;
        self.canvas.place(Area { left, top: 130, width: BAR, height: 9 }, |pixel| {
            let along = pixel as u32 % BAR;
            gray((along * 255 / (BAR - 1)) as u8)
        });
        self.words_right([left - 8, 140], "0", BODY);
    }

    fn row(&mut self, row: &Row, top: u32) {
        let [width, height] = row.source.size;
        let baseline = top + 25;
        let end = self.words([MARGIN, baseline], &row.title, LABEL);
        let room = column_left(2) - end - 34;
        let detail = self.typeface.fitted(&row.detail, room as f32, BODY);
        self.words([end + 14, baseline], &detail, BODY);
        let difference = differences(&row.source, &row.converted);
        self.words_right([column_left(2) + width, baseline], &figures(&difference), BODY);
        for (column, picture) in [&row.source, &row.converted].into_iter().enumerate() {
            let area = Area { left: column_left(column as u32), top: top + CAPTION, width, height };
            self.canvas.place(area, |pixel| {
                [picture.rgb[3 * pixel], picture.rgb[3 * pixel + 1], picture.rgb[3 * pixel + 2]]
            });
        }
        let area = Area { left: column_left(2), top: top + CAPTION, width, height };
        self.canvas.place(area, |pixel| gray((u32::from(difference[pixel]) * AMPLIFICATION).min(255) as u8));
        for column in 0..3 {
            self.arrows(row.arrows, [column_left(column) as f32, (top + CAPTION) as f32], height as f32);
        }
    }

    /// `corner` is the picture's, on the sheet.
    fn arrows(&mut self, arrows: Arrows, [left, top]: [f32; 2], height: f32) {
        const AWAY: f32 = 3.0;
        match arrows {
            Arrows::None => {}
            Arrows::Line { x } => {
                self.canvas.arrow([left + x, top - AWAY], Points::Down, ACCENT);
                self.canvas.arrow([left + x, top + height + AWAY], Points::Up, ACCENT);
            }
            Arrows::Place { x, y } => {
                self.canvas.arrow([left + x, top - AWAY], Points::Down, ACCENT);
                self.canvas.arrow([left - AWAY, top + y], Points::Right, ACCENT);
            }
        }
    }
}

/// The difference column's scale: nearly the paper's black for none, white for the most.
fn gray(amplified: u8) -> [u8; 3] {
    const NONE: [u8; 3] = [10, 10, 11];
    NONE.map(|none| (u32::from(none) + u32::from(amplified) * (255 - u32::from(none)) / 255) as u8)
}

/// Statistics over the whole picture, so that what the scale clips is still there in words.
fn figures(difference: &[u8]) -> String {
    let max = difference.iter().copied().max().unwrap_or(0);
    let sum: u64 = difference.iter().map(|d| u64::from(*d)).sum();
    let mean = sum as f64 / difference.len().max(1) as f64;
    format!("mean {mean:.2}, max {max} codes")
}
