//! Recoverable trouble, gathered while reading: one entry for each rule, with a count and the first place.

use crate::error::Warning;

#[derive(Debug, Default)]
pub(super) struct Warnings {
    list: Vec<Warning>,
}

impl Warnings {
    /// Counts `count` more cases of the rule `code`; place and words of the first case are kept.
    pub fn add_many(&mut self, code: &str, pointer: &str, detail: &str, count: u64) {
        if count == 0 {
            return;
        }
        match self.list.iter_mut().find(|warning| warning.code == code) {
            Some(warning) => warning.count = warning.count.saturating_add(count),
            None => self.list.push(Warning {
                code: code.to_owned(),
                detail: detail.to_owned(),
                pointer: pointer.to_owned(),
                count,
            }),
        }
    }

    pub fn add(&mut self, code: &str, pointer: &str, detail: &str) {
        self.add_many(code, pointer, detail, 1);
    }

    pub fn into_list(self) -> Vec<Warning> {
        self.list
    }
}
