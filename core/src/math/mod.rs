//! Numbers without a subject: color transfer, tangent frames, weighted means, disjoint sets, sparse systems.

pub mod cholesky;
pub mod frame;
pub mod mean;
pub mod partition;
pub mod transfer;
