//! The sheet as a whole, and the two renderers against each other.

mod sample;

use super::*;

/// Looks at a sheet with a person's eyes: `MESHCOLOR_SHEETS=folder` keeps what the tests draw.
fn keep(name: &str, sheet: &Sheet) {
    if let Ok(folder) = std::env::var("MESHCOLOR_SHEETS") {
        std::fs::write(std::path::Path::new(&folder).join(name), &sheet.png).expect("the folder is there");
    }
}

#[test]
fn a_ball_has_a_sheet() {
    let conversion = sample::ball();
    let drawn = sheet_titled(&conversion, "ball").expect("it is drawn");
    keep("ball.png", &drawn);
    let decoded = image::load_from_memory(&drawn.png).expect("it is a PNG");
    assert_eq!(decoded.width(), 1600);
}
