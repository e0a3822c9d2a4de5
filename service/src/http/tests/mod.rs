//! Every route and every refusal, against the router itself with a scripted runner.

mod bench;
mod events;
mod jobs;
mod ops;
mod results;
mod uploads;
