//! Polygons by `FB_ngon_encoding`.
#![no_main]

meshcolor_fuzz::reads!();
