//! where frames come from.
