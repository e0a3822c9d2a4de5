//! Signals during a conversion: the first one asks it to stop, so that nothing half-written stays; a
//! second one ends the process at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use anyhow::Context;
use tokio::signal::unix::{SignalKind, signal};

use super::Outcome;
use crate::watch::{Stop, StopReason};

/// The signal that came, if any.
#[derive(Clone, Default)]
pub struct Interrupt(Arc<AtomicU8>);

impl Interrupt {
    /// Listens on a thread of its own until the process ends.
    pub fn listen(stop: Arc<Stop>) -> anyhow::Result<Self> {
        let interrupt = Self::default();
        let number = interrupt.0.clone();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (mut interrupts, mut terminations) = {
            let _inside = runtime.enter();
            let listen = |kind| signal(kind).context("signals cannot be listened to");
            (listen(SignalKind::interrupt())?, listen(SignalKind::terminate())?)
        };
        std::thread::spawn(move || {
            runtime.block_on(async {
                loop {
                    let came = tokio::select! {
                        _ = interrupts.recv() => 2,
                        _ = terminations.recv() => 15,
                    };
                    if number.swap(came, Ordering::SeqCst) != 0 {
                        std::process::exit(128 + i32::from(came));
                    }
                    stop.set(StopReason::Canceled);
                }
            });
        });
        Ok(interrupt)
    }

    /// What the signal makes of an outcome.
    pub fn over(&self, outcome: Outcome) -> Outcome {
        match self.0.load(Ordering::SeqCst) {
            0 => outcome,
            number => Outcome::Signal(number),
        }
    }
}
