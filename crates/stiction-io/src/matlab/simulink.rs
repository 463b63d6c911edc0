//! Signals that Simulink logs as "Structure With Time" or "Structure".
//!
//! Such a struct has `time` and an array of structs `signals`, each with `values`, a `label` and the name of its
//! block. Without time, `time` is empty.

use super::value::{Fields, Value};
use crate::sheet::{Cells, Column, LeftOut, Sheet};

fn field<'f>(fields: &'f Fields, name: &str) -> Option<&'f Value> {
    fields.iter().find(|(each, _)| each == name).map(|(_, value)| value)
}

/// A name on one line, without the brackets of a label that Simulink propagates; none if unnamed.
fn name(fields: &Fields, key: &str) -> Option<String> {
    let Some(Value::Text(text)) = field(fields, key) else { return None };
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    // A block is named by its path.
    let last = if key == "blockName" { line.rsplit('/').next().unwrap_or("") } else { &*line };
    let bare = last.trim_matches(['<', '>']).trim();
    (!bare.is_empty()).then(|| bare.to_owned())
}

/// The sheet of a struct of Simulink, if it is one. `times` are the times of the whole simulation.
pub(super) fn sheet(
    fields: &Fields,
    part: &str,
    origin: &str,
    times: Option<&[f64]>,
) -> Option<Sheet> {
    let Some(Value::Structs(signals)) = field(fields, "signals") else { return None };
    let values = |signal: &Fields| match field(signal, "values") {
        Some(Value::Numbers { rows, cols, data }) => Some((*rows, *cols, data.clone())),
        _ => None,
    };
    let own = match field(fields, "time") {
        Some(Value::Numbers { data, .. }) if data.len() > 1 => Some(&data[..]),
        _ => None,
    };
    // A vector or matrix has time along its longer side, an array of more dimensions along its last.
    let length = own.map(<[f64]>::len).or_else(|| {
        signals.iter().find_map(|signal| values(signal).map(|(rows, cols, _)| rows.max(cols)))
    });
    let length = length.filter(|length| *length > 1)?;
    let mut sheet = Sheet { origin: origin.to_owned(), part: part.to_owned(), ..Sheet::default() };
    let add = |sheet: &mut Sheet, name: String, data: Vec<f64>| {
        sheet.columns.push(Column { name, unit: None, cells: Cells::Numbers(data) });
    };
    match (own, times.filter(|times| times.len() == length)) {
        (Some(own), _) => add(&mut sheet, "time".to_owned(), own.to_vec()),
        (None, Some(times)) => add(&mut sheet, "tout".to_owned(), times.to_vec()),
        (None, None) => {}
    }
    for (place, signal) in signals.iter().enumerate() {
        let own = format!("signals({})", place + 1);
        let name = name(signal, "label").or_else(|| name(signal, "blockName")).unwrap_or(own);
        let mut leave_out = |why: String| {
            sheet.left_out.push(LeftOut { name: name.clone(), why, holds_samples: true });
        };
        let Some((rows, _, data)) = values(signal) else {
            leave_out("has no numbers in \"values\"".to_owned());
            continue;
        };
        let width = data.len() / length;
        if width == 0 || width * length != data.len() {
            leave_out(format!("has {} values for {length} times", data.len()));
            continue;
        }
        for k in 0..width {
            let column = match rows == length {
                true => data[k * length..(k + 1) * length].to_vec(),
                false => data.iter().skip(k).step_by(width).copied().collect(),
            };
            let name = if width == 1 { name.clone() } else { format!("{name}(:,{})", k + 1) };
            add(&mut sheet, name, column);
        }
    }
    sheet.columns.iter().any(|column| column.name != "time").then_some(sheet)
}
