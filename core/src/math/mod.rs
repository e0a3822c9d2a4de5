//! Numbers without a subject: color transfer, tangent frames, weighted means.

pub mod frame;
pub mod mean;
pub mod transfer;
