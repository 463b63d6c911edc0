//! Cycles and maps as CSV.

use anyhow::Result;
use stiction::limit_cycle::exact::Trajectory;
use stiction::limit_cycle::map::{Map, Point};
use stiction_io::table;

/// A cycle over one period.
pub fn orbit(orbit: &Trajectory) -> String {
    let columns = [("t", &orbit.time_s), ("op", &orbit.op), ("vp", &orbit.vp), ("pv", &orbit.pv)];
    table::write(&columns.map(|(name, values)| (name, Some(&values[..]))))
}

/// One row for each point of a map.
pub fn map(map: &Map) -> Result<String> {
    let mut writer = csv::Writer::from_writer(vec![]);
    let names = [map.x.parameter.name(), map.y.parameter.name()];
    let head = ["state", "period_s", "half_pp_op", "half_pp_vp", "half_pp_pv", "slips", "reason"];
    writer.write_record(names.iter().chain(&head))?;
    for (row, y) in map.y.values.iter().enumerate() {
        for (column, x) in map.x.values.iter().enumerate() {
            let Some(point) = map.at(column, row) else { continue };
            let mut record = vec![x.to_string(), y.to_string(), point.state().name().to_owned()];
            match point {
                Point::Cycle { period_s, half_pp, slips } => {
                    let numbers = [*period_s, half_pp.op, half_pp.vp, half_pp.pv];
                    record.extend(numbers.map(|value| value.to_string()));
                    record.extend([slips.to_string(), String::new()]);
                }
                Point::NoCycle { reason } | Point::Unknown { reason } => {
                    record.extend(std::iter::repeat_n(String::new(), 5));
                    record.push(reason.clone());
                }
            }
            writer.write_record(&record)?;
        }
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}
