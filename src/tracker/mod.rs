//! the seam tracker.
