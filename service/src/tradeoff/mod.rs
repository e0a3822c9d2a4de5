//! What accuracy costs on one asset. In time: every rung of every ladder and the whole presets. In texels: the curve
//! of texels against error. As a record, tables and pictures.

mod curve;
mod errors;
mod front;
mod plan;
mod plot;
mod record;
mod run;
mod table;
#[cfg(test)]
mod tests;
mod words;

pub use curve::{
    Curve, Figures, Line, MapError, Point, PointEnd, headline as curve_headline, table as curve_table,
};
pub use errors::errors_of;
pub use plan::{HOME, Plan};
pub use plot::{curve_svg, curves_svg, svg};
pub use record::{Cost, Done, End, Errors, Machine, Run, Tradeoff, UnitErrors};
pub use run::{Manner, Subject, cost_of, run};
pub use table::{markdown, runs as runs_table};
pub use words::{figure, headline, time};

use meshcolor::write::BundleFile;
use meshcolor::{Error, Result};

/// The record's own name; the table and the picture stand beside it.
pub const RECORD_FILE: &str = "tradeoff.json";

/// The record, the tables, and each picture twice, below `folder` (empty, or with a slash at its end).
///
/// # Errors
/// `Internal` where the picture cannot be drawn, which no record can cause.
pub fn files(record: &Tradeoff, folder: &str) -> Result<Vec<BundleFile>> {
    let internal = |error: &dyn std::fmt::Display| Error::internal(format!("the tradeoff: {error}"));
    let mut json = serde_json::to_vec_pretty(record).map_err(|error| internal(&error))?;
    json.push(b'\n');
    let file = |name: &str, bytes| BundleFile { path: format!("{folder}{name}"), bytes };
    let mut files = vec![file(RECORD_FILE, json), file("tradeoff.md", markdown(record).into_bytes())];
    let pictures = [("tradeoff", Some(svg(record))), ("curve", curve_svg(record))];
    for (name, svg) in pictures.into_iter().filter_map(|(name, svg)| Some((name, svg?))) {
        let png = crate::plot::png(&svg).map_err(|error| internal(&format!("{error:#}")))?;
        files.push(file(&format!("{name}.svg"), svg.into_bytes()));
        files.push(file(&format!("{name}.png"), png));
    }
    Ok(files)
}
