//! Sweeps out what only replaced things used, and renumbers the rest.
//!
//! What the source did not use itself is kept: it is there for a reason that is not known here. A file
//! with an extension whose pointers are not known is left in place as a whole.

use serde_json::Value;

use crate::asset::Document;
use crate::error::Result;

use super::draft::Draft;
use super::extensions;
use super::references::{self, Kind};

const KINDS: [Kind; 5] = [Kind::Texture, Kind::Sampler, Kind::Image, Kind::Accessor, Kind::View];

/// For each array, whether an item is in use.
struct Marks([Vec<bool>; 5]);

impl Marks {
    fn none(draft: &Draft<'_>) -> Self {
        Self(KINDS.map(|kind| vec![false; count(draft, kind)]))
    }

    fn of(&mut self, kind: Kind) -> &mut Vec<bool> {
        &mut self.0[position(kind)]
    }

    /// Marks what a pointer points at; a pointer out of range marks nothing.
    fn mark(&mut self, kind: Kind, pointer: &Value) {
        let index = pointer.as_u64().and_then(|number| usize::try_from(number).ok());
        if let Some(mark) = index.and_then(|index| self.of(kind).get_mut(index)) {
            *mark = true;
        }
    }

    /// Follows the marked items. `KINDS` stands in the order of the arrows, so one pass is enough.
    fn follow(&mut self, draft: &mut Draft<'_>) {
        for kind in KINDS {
            let Some(mut items) = take(draft, kind) else { continue };
            let marked = self.of(kind).clone();
            for (item, _) in items.iter_mut().zip(marked).filter(|(_, marked)| *marked) {
                references::visit_item(kind, item, &mut |kind, pointer| self.mark(kind, pointer));
            }
            put(draft, kind, items);
        }
    }
}

/// Removes the items that the source used and the draft does not, and moves all pointers.
pub fn sweep(draft: &mut Draft<'_>, source: &Document) -> Result<()> {
    if extensions::names(draft).iter().any(|name| !references::understood(name)) {
        return Ok(());
    }
    let mut original = Draft::open(source)?;
    let mut before = Marks::none(&original);
    references::visit_roots(&mut original, &mut |kind, pointer| before.mark(kind, pointer));
    before.follow(&mut original);

    let mut keep = Marks::none(draft);
    references::visit_roots(draft, &mut |kind, pointer| keep.mark(kind, pointer));
    for kind in KINDS {
        let used_before = before.of(kind);
        for (keep, used) in keep.of(kind).iter_mut().zip(used_before) {
            *keep |= !*used;
        }
    }
    keep.follow(draft);
    renumber(draft, &mut keep);
    Ok(())
}

fn renumber(draft: &mut Draft<'_>, keep: &mut Marks) {
    let numbers = KINDS.map(|kind| {
        let mut next = 0u64;
        let number = |keep: &bool| {
            let own = next;
            next += u64::from(*keep);
            own
        };
        keep.of(kind).iter().map(number).collect::<Vec<u64>>()
    });
    let mut move_pointer = |kind: Kind, pointer: &mut Value| {
        let index = pointer.as_u64().and_then(|number| usize::try_from(number).ok());
        if let Some(number) = index.and_then(|index| numbers[position(kind)].get(index)) {
            *pointer = (*number).into();
        }
    };
    references::visit_roots(draft, &mut move_pointer);
    for kind in KINDS {
        let Some(mut items) = take(draft, kind) else { continue };
        for item in &mut items {
            references::visit_item(kind, item, &mut move_pointer);
        }
        retain(&mut items, keep.of(kind));
        put(draft, kind, items);
    }
    retain(&mut draft.views, keep.of(Kind::View));
}

fn retain<T>(items: &mut Vec<T>, keep: &[bool]) {
    let mut keep = keep.iter();
    items.retain(|_| keep.next().copied().unwrap_or(true));
}

fn position(kind: Kind) -> usize {
    match kind {
        Kind::Texture => 0,
        Kind::Sampler => 1,
        Kind::Image => 2,
        Kind::Accessor => 3,
        Kind::View => 4,
    }
}

fn count(draft: &Draft<'_>, kind: Kind) -> usize {
    match kind {
        Kind::Texture => draft.textures.len(),
        Kind::Sampler => draft.samplers.len(),
        Kind::Image => draft.images.len(),
        Kind::Accessor => draft.accessors.len(),
        Kind::View => draft.views.len(),
    }
}

/// The array of a kind that points further; buffer views do not.
fn array<'d>(draft: &'d mut Draft<'_>, kind: Kind) -> Option<&'d mut Vec<Value>> {
    match kind {
        Kind::Texture => Some(&mut draft.textures),
        Kind::Sampler => Some(&mut draft.samplers),
        Kind::Image => Some(&mut draft.images),
        Kind::Accessor => Some(&mut draft.accessors),
        Kind::View => None,
    }
}

fn take(draft: &mut Draft<'_>, kind: Kind) -> Option<Vec<Value>> {
    array(draft, kind).map(std::mem::take)
}

fn put(draft: &mut Draft<'_>, kind: Kind, items: Vec<Value>) {
    if let Some(array) = array(draft, kind) {
        *array = items;
    }
}
