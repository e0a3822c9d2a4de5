//! `meshcolor openapi`: the document that `openapi.yaml` holds.

use std::io::{Write, stdout};

use super::Outcome;

pub fn run() -> anyhow::Result<Outcome> {
    let text = crate::http::document().map_err(|error| anyhow::anyhow!(error))?;
    stdout().write_all(text.as_bytes())?;
    Ok(Outcome::Fine)
}
