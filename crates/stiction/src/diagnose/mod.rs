//! From a recording to a verdict with its evidence.

mod kpis;

pub use kpis::{Kpi, KpiOptions, Kpis, harris_index};
