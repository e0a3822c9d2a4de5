//! `meshcolor serve`: the HTTP service until a signal comes.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use tokio::signal::unix::{SignalKind, signal};

use super::Outcome;
use super::arguments::thread_count;
use crate::server::{Config, Server};
use crate::settings::Settings;
use crate::work::processor_count;

#[derive(clap::Args)]
pub struct Arguments {
    /// Where to listen
    #[arg(long, env = "MESHCOLOR_BIND", value_name = "ADDRESS", default_value = DEFAULT_BIND)]
    bind: SocketAddr,
    /// The folder that holds jobs and results; one server at a time
    #[arg(long, env = "MESHCOLOR_DATA", value_name = "FOLDER", default_value = "meshcolor-data")]
    data: PathBuf,
    /// Jobs that run at a time; they share the threads
    #[arg(long, env = "MESHCOLOR_WORKERS", value_name = "COUNT", default_value_t = default_workers(), value_parser = thread_count)]
    workers: usize,
    /// Threads that convert
    #[arg(long, env = "MESHCOLOR_THREADS", value_name = "COUNT", default_value_t = processor_count(), value_parser = thread_count)]
    threads: usize,
    #[command(flatten)]
    settings: Settings,
}

pub const DEFAULT_BIND: &str = "127.0.0.1:8080";

/// Each job uses all threads while it computes, so a few suffice; each one more costs its memory.
fn default_workers() -> usize {
    processor_count().div_ceil(2).min(4)
}

pub fn run(arguments: Arguments) -> anyhow::Result<Outcome> {
    crate::logging::start("info");
    let config = Config {
        bind: arguments.bind,
        data: arguments.data,
        worker_count: arguments.workers,
        threads: arguments.threads,
        settings: arguments.settings,
    };
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let result = runtime.block_on(serve(config));
    // A conversion that does not listen must not keep the process; the next start runs it again.
    runtime.shutdown_timeout(Duration::from_secs(1));
    result.map(|()| Outcome::Fine)
}

async fn serve(config: Config) -> anyhow::Result<()> {
    let mut interrupts = signal(SignalKind::interrupt())?;
    let mut terminations = signal(SignalKind::terminate())?;
    let server = Server::start(config).await?;
    eprintln!("meshcolor serves http://{}", server.address);
    tokio::select! {
        _ = interrupts.recv() => {}
        _ = terminations.recv() => {}
    }
    let stopping = server.stop();
    tokio::select! {
        () = stopping => {}
        // A second signal does not wait; what ran is run again at the next start.
        _ = interrupts.recv() => {}
        _ = terminations.recv() => {}
    }
    Ok(())
}
