//! Lists and inserts settings in the text of a scenario.

use crate::error::{Error, Result};

/// Every setting of a scenario, with its dotted key, its value as TOML, and its unit, if any.
pub fn listed(text: &str) -> Vec<(String, String, &'static str)> {
    let mut settings = vec![];
    if let Ok(document) = text.parse::<toml_edit::DocumentMut>() {
        collect(document.as_table(), "", &mut settings);
    }
    settings.retain(|(key, ..)| key != "title");
    settings
}

fn collect(
    table: &dyn toml_edit::TableLike,
    path: &str,
    into: &mut Vec<(String, String, &'static str)>,
) {
    for (key, item) in table.iter() {
        let path = if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
        if let Some(list) = item.as_array_of_tables() {
            for (i, table) in list.iter().enumerate() {
                collect(table, &format!("{path}.{i}"), into);
            }
        } else if let Some(table) = item.as_table_like() {
            collect(table, &path, into);
        } else if let Some(value) = item.as_value() {
            let value = value.clone().decorated("", "").to_string();
            into.push((path, value, unit(key)));
        }
    }
}

/// Unit of the setting called `key`, if it is the same in every table.
fn unit(key: &str) -> &'static str {
    match key {
        "sample_time" | "duration" | "period" | "tau" | "tau2" | "delay" | "ti" | "td" | "lag"
        | "filter" | "tracking_time" | "dwell" => "s",
        "S" | "J" | "fs" | "fd" => "% of span",
        "op" => "%",
        "rest_tolerance" => "%/s",
        _ => "",
    }
}

/// `text` with each `key=value` of `settings` inserted.
pub fn apply(text: &str, settings: &[String]) -> Result<String> {
    let error = |setting: &str, message: String| Error::Setting {
        settings: vec![setting.to_owned()],
        message,
    };
    let mut document: toml_edit::DocumentMut = text
        .parse()
        .map_err(|e: toml_edit::TomlError| error(&settings.join(" "), e.message().to_owned()))?;
    for setting in settings {
        let (path, value) = setting.split_once('=').ok_or_else(|| {
            error(setting, "is not of the form key=value, such as valve.S=4".to_owned())
        })?;
        // A bare word is a text, because quoting quotes on a command line is awkward.
        let value = value.trim();
        let value = value.parse().unwrap_or_else(|_| toml_edit::Value::from(value));
        let keys: Vec<&str> = path.trim().split('.').collect();
        put(document.as_table_mut(), &keys, value).map_err(|message| error(setting, message))?;
    }
    Ok(document.to_string())
}

/// Inserts `value` at the path `keys` below `table`. A number in the path is the index in an array of tables, from 0.
fn put(
    table: &mut dyn toml_edit::TableLike,
    keys: &[&str],
    value: toml_edit::Value,
) -> std::result::Result<(), String> {
    let Some((first, rest)) = keys.split_first().filter(|(first, _)| !first.is_empty()) else {
        return Err("the key is incomplete; write, for instance, valve.S=4".to_owned());
    };
    if rest.is_empty() {
        let mut value = value;
        if let Some(old) = table.get(first).and_then(toml_edit::Item::as_value) {
            // With the comment behind it, which gives its unit.
            *value.decor_mut() = old.decor().clone();
        }
        table.insert(first, toml_edit::Item::Value(value));
        return Ok(());
    }
    let index = rest[0].parse::<usize>().ok();
    let item = table.entry(first).or_insert_with(|| match index {
        Some(_) => toml_edit::array(),
        None => toml_edit::table(),
    });
    // `load = [{ value = 1 }]` is equivalent to `[[load]]`.
    let inline = item.as_array().is_some_and(|list| list.iter().all(|v| v.is_inline_table()));
    if inline && index.is_some() {
        let list = std::mem::take(item).into_array_of_tables();
        *item = list.map_or_else(|item| item, toml_edit::Item::ArrayOfTables);
    }
    if let Some(list) = item.as_array_of_tables_mut() {
        let count = list.len();
        if index == Some(count) {
            list.push(toml_edit::Table::new());
        }
        let table = index.and_then(|index| list.get_mut(index)).ok_or_else(|| {
            format!(
                "\"{first}\" has {count} tables; count them from {first}.0, and write \
                 {first}.{count} to add one"
            )
        })?;
        return put(table, &rest[1..], value);
    }
    match item.as_table_like_mut() {
        Some(table) => put(table, rest, value),
        None => Err(format!("\"{first}\" is a value, not a table")),
    }
}
