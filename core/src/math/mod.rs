//! Numbers without a subject: color transfer, tangent frames, weighted means, disjoint sets.

pub mod frame;
pub mod mean;
pub mod partition;
pub mod transfer;
