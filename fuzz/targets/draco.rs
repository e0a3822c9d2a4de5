//! A primitive in a Draco stream.
#![no_main]

meshcolor_fuzz::reads!();
