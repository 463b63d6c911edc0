//! One setting of a mapping file as `KEY=VALUE`, as the command line gives it.

use super::mapping::LOOP_KEYS;
use super::options::{Mapped, ReadOptions};
use super::role::Role;
use crate::error::Error;
use std::str::FromStr;
use toml::{Table, Value};

/// Tables whose keys are words and codes of the file, so that the rest of a key is one of these.
const WORDS: [&str; 3] = ["modes", "quality", "signals"];

impl FromStr for ReadOptions {
    type Err = String;

    /// Reads `KEY=VALUE`: a role with its column, such as `op=OUT` or `FIC101.op=OUT`, or a key of a mapping file with
    /// its value, such as `op_range=4,20`, `FIC101.op_range=4,20`, `modes.16=auto` or `zone=Europe/Berlin`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) = text.split_once('=').ok_or_else(|| {
            format!(
                "\"{text}\" is not ROLE=COLUMN, such as op=OUT, or KEY=VALUE, such as op_range=4,20"
            )
        })?;
        let (key, value) = (key.trim(), value.trim());
        let (loop_name, last) =
            key.rsplit_once('.').map_or((None, key), |(of, last)| (Some(of), last));
        let mapped =
            || Mapped::of(key, value).map(|mapped| Self { map: vec![mapped], ..Self::default() });
        let table = key.split_once('.').filter(|(table, _)| WORDS.contains(table));
        if let Some(said) = table.and_then(|(table, word)| at(&[table, word], value).ok()) {
            return Ok(said);
        }
        match loop_name {
            _ if Role::by_name(last).is_some() => mapped(),
            Some(loop_name) if LOOP_KEYS.split(' ').any(|key| key == last) => {
                at(&["loop", loop_name, last], value)
            }
            _ => match (table, at(&[key], value)) {
                (Some((table, word)), _) => at(&[table, word], value),
                // A word that is no key at all is meant as a role.
                (None, Err(wrong)) if wrong.starts_with("unknown key") => {
                    mapped().map_err(|no_role| format!("{no_role}; {wrong}"))
                }
                (None, said) => said,
            },
        }
    }
}

/// The options of a mapping file with only this value. As on the command line, a value has no type. The first type with
/// which the file can be read counts: a number, numbers, a text, texts.
fn at(path: &[&str], text: &str) -> Result<ReadOptions, String> {
    let numbers = text.split(',').map(|part| part.trim().parse::<f64>().ok());
    let numbers: Option<Vec<Value>> =
        numbers.map(|number| number.filter(|n| n.is_finite()).map(Value::Float)).collect();
    let mut values = vec![];
    if let Some(numbers) = numbers {
        if let [number] = &numbers[..] {
            values.push(number.clone());
        }
        values.push(Value::Array(numbers));
    }
    let word = Value::String(text.to_owned());
    values.extend([word.clone(), Value::Array(vec![word])]);
    let mut first = None;
    for value in values {
        let nested = path
            .iter()
            .rev()
            .fold(value, |value, key| Value::Table(Table::from_iter([((*key).to_owned(), value)])));
        // Texts, numbers and tables of them can always be written.
        let document = toml::to_string(&nested).unwrap_or_default();
        match ReadOptions::parse(&document, "").map_err(message) {
            Ok(options) => return Ok(ReadOptions { mapping: None, ..options }),
            Err(wrong) => first = first.or(Some(wrong)),
        }
    }
    Err(first.unwrap_or_default())
}

/// What is wrong, without a line of a file that does not exist.
fn message(error: Error) -> String {
    match error {
        Error::Mapping { message, .. } => message,
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::role::Signal;

    #[test]
    fn a_setting_is_what_the_mapping_file_says() {
        for (setting, file) in [
            ("op=OUT", "[columns]\nOUT = \"op\""),
            ("FIC1.op=OUT", "[columns]\nOUT = \"FIC1.op\""),
            ("quality=Q", "[columns]\nQ = \"quality\""),
            ("quality.op=Q", "[columns]\nQ = \"quality.op\""),
            ("op_range=4,20", "op_range = [4, 20]"),
            ("UNIT/A.FIC1.op_range=4,20", "[loop.\"UNIT/A.FIC1\"]\nop_range = [4, 20]"),
            ("FIC1.type=level", "[loop.FIC1]\ntype = \"level\""),
            ("type=level", "type = \"level\""),
            ("modes.16=auto", "[modes]\n16 = \"auto\""),
            ("modes.1.5=auto", "[modes]\n\"1.5\" = \"auto\""),
            ("quality.0=good", "[quality]\n0 = \"good\""),
            ("signals.pv=MEAS", "[signals]\npv = [\"MEAS\"]"),
            ("zone=Europe/Berlin", "zone = \"Europe/Berlin\""),
            ("time_format=day-first", "time_format = \"day-first\""),
            ("sample_time=0.5", "sample_time = 0.5"),
            ("pattern={loop}.{signal}", "pattern = \"{loop}.{signal}\""),
            ("bad_text=Kaputt", "bad_text = [\"Kaputt\"]"),
            ("bad_text=999", "bad_text = [\"999\"]"),
        ] {
            let said: ReadOptions = setting.parse().expect(setting);
            let in_file = ReadOptions { mapping: None, ..ReadOptions::parse(file, "").unwrap() };
            assert_eq!(said, in_file, "{setting}");
        }
    }

    #[test]
    fn what_is_no_setting_names_the_remedy() {
        for (setting, expected) in [
            ("op", "\"op\" is not ROLE=COLUMN, such as op=OUT, or KEY=VALUE"),
            ("opp=pv", "\"opp\" is not a role; roles are time, date, op"),
            ("FIC1.opp=pv", "\"opp\" is not a role"),
            ("op_range=20,4", "op_range: must be two numbers, the lower one first"),
            ("FIC1.op_range=wide", "loop.FIC1.op_range: must be a list of numbers"),
            ("zone=Berlin", "zone: \"Berlin\" is not a time zone"),
            ("sample_time=0", "sample_time: must be above 0 s"),
            ("modes.16=car", "modes.16: is \"car\", but must be one of \"auto\""),
            ("quality.0=fine", "quality.0: is \"fine\", but must be one of \"good\""),
        ] {
            let wrong = setting.parse::<ReadOptions>().unwrap_err();
            assert!(wrong.starts_with(expected), "{setting}: {wrong}");
        }
    }

    #[test]
    fn what_is_over_counts_first() {
        let all = |texts: &[&str]| {
            let each = texts.iter().map(|text| text.parse::<ReadOptions>().unwrap());
            each.fold(ReadOptions::default(), |below, each| each.over(below))
        };
        let told = all(&["A.op_range=0,1", "A.type=flow", "op_range=0,9", "a.op_range=0,2"]);
        let by_name = crate::columns::options::SettingsByName::of(&told);
        assert_eq!(by_name.of_loop("A").op_range, Some((0.0, 2.0)));
        assert!(by_name.of_loop("A").loop_type.is_some());
        assert_eq!(by_name.of_loop("B").op_range, Some((0.0, 9.0)));
        let told =
            all(&["signals.pv=X", "modes.3=auto", "modes.3=manual", "bad_text=x", "bad_text=y"]);
        assert_eq!(told.modes[0].1, stiction_recording::recording::Mode::Manual);
        assert_eq!((told.bad_text.len(), told.signals[0].0), (2, Signal::Pv));
    }
}
