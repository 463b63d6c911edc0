//! Any sequence of calls into the FMU library: nothing crashes, and what is refused is logged. The bytes
//! are calls as `addons/stiction-fmu/tests/sequences.rs` draws them too.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;

#[path = "../../addons/stiction-fmu/tests/common/mod.rs"]
mod common;

use common::{Unpacked, calls};

static MODELS: LazyLock<Vec<Unpacked>> = LazyLock::new(calls::unpacked);

fuzz_target!(|bytes: &[u8]| {
    calls::play(bytes, &MODELS);
});
