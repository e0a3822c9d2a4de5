//! Progress on a terminal: one bar that names the stage. Nothing is drawn elsewhere.

use std::io::{IsTerminal, stderr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use tokio::sync::watch::Receiver;

use crate::watch::Progress;

/// How often the bar looks.
const TICK: Duration = Duration::from_millis(80);

/// A bar that follows a job until it is dropped.
pub struct Bar {
    is_over: Arc<AtomicBool>,
    drawing: Option<JoinHandle<()>>,
}

impl Bar {
    pub fn follow(name: String, progress: Receiver<Progress>, is_quiet: bool) -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let is_shown = !is_quiet && stderr().is_terminal();
        let drawing = is_shown.then(|| {
            let is_over = is_over.clone();
            std::thread::spawn(move || draw(name, &progress, &is_over))
        });
        Self { is_over, drawing }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::SeqCst);
        if let Some(drawing) = self.drawing.take() {
            // A thread that panicked drew badly, which is no reason to fail.
            let _ = drawing.join();
        }
    }
}

/// A bar on standard error in the house's style.
pub fn bar(name: String) -> ProgressBar {
    let template = "{prefix} [{bar:32}] {percent:>3} % {msg} ({elapsed})";
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(100).with_style(style.progress_chars("=> ")).with_prefix(name)
}

fn draw(name: String, progress: &Receiver<Progress>, is_over: &AtomicBool) {
    let bar = bar(name);
    while !is_over.load(Ordering::SeqCst) {
        let now = *progress.borrow();
        bar.set_position(u64::from(now.percent));
        bar.set_message(now.stage.unwrap_or_default());
        std::thread::sleep(TICK);
    }
    bar.finish_and_clear();
}
