//! The log: lines for people on a terminal, JSON elsewhere, always on standard error.

use std::io::{IsTerminal, stderr};

use tracing_subscriber::EnvFilter;

/// Starts the log; `MESHCOLOR_LOG` sets what is shown (such as `debug` or `meshcolor_service=trace`).
pub fn start(default_level: &str) {
    let filter = EnvFilter::try_from_env("MESHCOLOR_LOG").unwrap_or_else(|_| EnvFilter::new(default_level));
    let is_terminal = stderr().is_terminal();
    let log = tracing_subscriber::fmt().with_env_filter(filter).with_writer(stderr).with_target(false);
    // An error says that a log runs already, as it may in tests.
    let _ = if is_terminal {
        log.with_ansi(std::env::var_os("NO_COLOR").is_none()).try_init()
    } else {
        log.json().flatten_event(true).try_init()
    };
}
