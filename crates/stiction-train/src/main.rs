//! Trains the model of the verdict on simulated loops.

fn main() {}
