//! Numbers without a subject: color transfer, tangent frames, weighted means, disjoint sets, sparse systems, matchings, random ones.

pub mod cholesky;
pub mod frame;
pub mod matching;
pub mod mean;
pub mod partition;
pub mod random;
pub mod transfer;
