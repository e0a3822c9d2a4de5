//! Prints the table of the hard cases with the time of each: what converting it takes on one thread with the default
//! options, without reading, the least of five. `MESHCOLOR_WRITE_DOCS=1` writes it to the page.
//!
//! ```text
//! cargo run --release -p meshcolor-tests --example hard_cases
//! ```

use std::collections::BTreeMap;
use std::time::Instant;

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
        let start = Instant::now();
        hard.convert(&RUNS[0]).ok()?;
        least = least.min(start.elapsed().as_secs_f64() * 1e3);
    }
    Some(format!("{least:.1}"))
}
