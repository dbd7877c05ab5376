//! median filter, centreline, seam features, stripe geometry.
