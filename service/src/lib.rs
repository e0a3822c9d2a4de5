//! The service and the command line around the conversion.

pub mod sample;
