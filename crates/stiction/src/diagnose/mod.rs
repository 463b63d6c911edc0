//! From a recording to a verdict with its evidence.
