//! Canvas mesh: weld, topology.
