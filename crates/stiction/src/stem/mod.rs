//! The physical stem.
