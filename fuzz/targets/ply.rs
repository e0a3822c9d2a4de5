//! PLY, in text and in bytes.
#![no_main]

meshcolor_fuzz::reads!();
