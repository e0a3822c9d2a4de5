//! Prints the table of the hard cases with the time of each: what the stages from
//! sampling to solving take on one thread with the default options, the least of five. `MESHCOLOR_WRITE_DOCS=1` writes it to the page.
//!
//! ```text
//! cargo run --release -p meshcolor-tests --example hard_cases
//! ```

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use meshcolor::watch::{Stage, Watch};
use meshcolor_tests::hard::{self, HardCase, RUNS, page};
use meshcolor_tests::repository::{hold, writes_documents};

const REPEATS: usize = 5;

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let names = hard::names().into_iter();
    let times: BTreeMap<String, String> =
        names.filter_map(|name| Some((name.clone(), pool.install(|| milliseconds(&name))?))).collect();
    let table = page::text(&times);
    if writes_documents() {
        hold(page::DOCUMENT, page::MARK, &table);
    } else {
        print!("{table}");
    }
}

/// `None` where the model is refused.
fn milliseconds(name: &str) -> Option<String> {
    let hard = HardCase::load(name);
    let mut least = f64::INFINITY;
    for _ in 0..REPEATS {
        let clock = Clock(Mutex::new((Stage::Read, Instant::now(), 0.0)));
        hard.convert(&RUNS[0], &clock).ok()?;
        least = least.min(clock.milliseconds());
    }
    Some(format!("{least:.1}"))
}

/// The stage that runs, since when, and the milliseconds of the stages that count.
struct Clock(Mutex<(Stage, Instant, f64)>);

impl Clock {
    fn milliseconds(&self) -> f64 {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).2
    }
}

impl Watch for Clock {
    fn stage(&self, stage: Stage) {
        let mut clock = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (before, since, sum) = *clock;
        let counts = !matches!(before, Stage::Read | Stage::Measure | Stage::Write);
        let spent = if counts { since.elapsed().as_secs_f64() * 1e3 } else { 0.0 };
        *clock = (stage, Instant::now(), sum + spent);
    }
}
