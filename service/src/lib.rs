//! Mesh color textures as an HTTP service and a command line: everything around the conversion that has
//! a clock, a network, an environment or a disk.
//!
//! `work` does one conversion with its picture and clocks; `jobs` keeps and runs them; `http` offers
//! them; `cli` is the command line; `settings` holds every limit once; `sample` makes the demo's model;
//! `tradeoff` runs every rung and shows what each costs, `scaling` shows how that grows, `plot` draws both.

pub mod bundle;
pub mod cli;
pub mod clock;
pub mod demo;
pub mod http;
pub mod input;
pub mod jobs;
pub mod logging;
pub mod plot;
pub mod sample;
pub mod scaling;
pub mod server;
pub mod settings;
pub mod sheet;
pub mod tradeoff;
pub mod watch;
pub mod work;
