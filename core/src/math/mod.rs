//! Numbers without a subject: color transfer and the geometry of sample grids.

pub mod transfer;
