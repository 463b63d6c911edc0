//! What cells mean once it is known what their column holds.

pub mod mode;
pub mod number;
pub mod quality;
pub mod range;
