//! The tests of `stiction-diagnose`, in one program: linking is what takes long.

mod by_hand;
#[path = "../../stiction-model/tests/common/mod.rs"]
mod common;
mod detect_shapes_properties;
mod detect_shapes_reference;
mod detect_statistics;
mod detect_valve_position;
mod oscillation_reference;
mod ramps;
mod staircase;
mod what_if;
