//! Common parts of several methods: their measures, and the figures of these.

pub mod curvature;
#[cfg(feature = "figure")]
pub mod drawn_rests;
#[cfg(feature = "figure")]
pub mod drawn_shapes;
#[cfg(feature = "figure")]
pub mod drawn_windows;
pub mod ellipse;
pub mod shapes;
pub mod stuck;
pub mod windows;
