//! Quantized attributes in packed buffer views.
#![no_main]

meshcolor_fuzz::reads!();
