//! Pictures of figures: a small SVG writer in the house's colors, axes, and PNG from SVG with the one font
//! that the program carries.
//!
//! Every number in the text is rounded to a tenth of a unit, so equal records give equal bytes.

mod axis;
mod raster;
mod svg;

pub use axis::Axis;
pub use raster::png;
pub use svg::{Anchor, Style, Svg, text_width};

/// Colors, as SVG writes them. The background is part of the picture, so it reads on light and dark pages.
pub mod ink {
    pub const BACKGROUND: &str = "#15171a";
    pub const PANEL: &str = "#1c1f23";
    pub const GRID: &str = "#30353b";
    pub const TEXT: &str = "#f0ede6";
    pub const MUTED: &str = "#a3a8ae";
    pub const FAINT: &str = "#5d646c";
    pub const AMBER: &str = "#f5b44c";
    pub const TEAL: &str = "#58c4bb";
    pub const CORAL: &str = "#f0836b";
}
