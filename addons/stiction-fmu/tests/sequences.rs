//! Any sequence of calls: nothing crashes, and what is refused is logged.

use crate::common;

use common::calls;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..Default::default() })]

    #[test]
    fn no_sequence_of_calls_does_harm(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        calls::play(&bytes, &calls::unpacked());
    }
}
