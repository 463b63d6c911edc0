//! The stored row of two loops that may swing in step in a week.

use crate::store::table::columns;

columns! {
    /// Two loops that may swing in step in a band.
    pub struct Pair;
    /// Tag of the loop that is the first by name.
    "loop" [""] first: String;
    /// Tag of the other.
    "other" [""] second: String;
    /// The band, the slowest first.
    "band" [""] band: i64;
    /// Probability of this coherence by chance, in the best of the compared bands.
    "p" [""] p: f64;
    /// Squared coherence, 0 to 1.
    "squared" [""] squared: f64;
}
