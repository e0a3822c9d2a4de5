//! Mesh colors, read and checked.
#![no_main]

use meshcolor::error::ErrorCode;
use meshcolor::pipeline::{self, Options};
use meshcolor::watch::Unwatched;
use meshcolor_fuzz::libfuzzer_sys::fuzz_target;

fuzz_target!(|file: &[u8]| {
    if meshcolor_fuzz::read(file).is_none() {
        return;
    }
    let checked = pipeline::check(
        &meshcolor_fuzz::upload(file),
        &Options::default(),
        &meshcolor_fuzz::limits(),
        &Unwatched,
    );
    if let Err(error) = checked {
        assert_ne!(error.code, ErrorCode::Internal, "{error}");
    }
});

meshcolor_fuzz::mutates!();
