//! scenario, scene, rendered frames and truth.
