//! A texture of Basis Universal in KTX2.
#![no_main]

meshcolor_fuzz::reads!();
