//! A texture in WebP.
#![no_main]

meshcolor_fuzz::reads!();
