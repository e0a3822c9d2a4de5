//! `meshcolor version`: what this program is, on one line.

use std::io::{Write, stdout};

use super::Outcome;
use crate::http::Version;

pub fn run() -> anyhow::Result<Outcome> {
    writeln!(stdout(), "{}", Version::current().text())?;
    Ok(Outcome::Fine)
}
