//! The tests of `stiction-model`, in one program: linking is what takes long.

mod closed_loop_properties;
mod closed_loop_reference;
mod common;
mod compensate;
mod lanes;
mod limit_cycle_describing_function;
mod limit_cycle_exact;
mod own_loop;
mod stem_laws;
mod stem_properties;
mod stem_reference;
mod valve_properties;
mod valve_reference;
mod valve_spec;
