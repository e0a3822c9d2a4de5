//! Jobs: what they are (`model`), where they are kept (`store`, `sqlite`, `folder`), who runs them
//! (`runner`), and the queue between.

pub mod folder;
pub mod model;
pub mod queue;
pub mod runner;
pub mod sqlite;
pub mod store;
#[cfg(test)]
pub mod testing;
