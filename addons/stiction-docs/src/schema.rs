//! A JSON schema as Markdown: a table of fields for each kind of object.

use crate::markdown::literal;
use serde_json::{Map, Value};
use std::fmt::Write as _;

/// The tables of a schema, its own object first; headings are of the second level.
pub fn tables(schema: &Value) -> String {
    let mut text = String::new();
    if let Some(about) = schema["description"].as_str() {
        let _ = writeln!(text, "{}\n", one_line(about));
    }
    fields(schema, &mut text);
    for (name, of) in schema["$defs"].as_object().into_iter().flatten() {
        let _ = writeln!(text, "## {}\n", literal(name));
        if let Some(about) = of["description"].as_str() {
            let _ = writeln!(text, "{}\n", one_line(about));
        }
        fields(of, &mut text);
    }
    text
}

/// A description in one line, including its list.
fn one_line(description: &str) -> String {
    let lines = description.lines().map(|line| line.trim_start_matches("* "));
    literal(&lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" "))
}

/// The content of an object, or its possible words or forms.
fn fields(of: &Value, text: &mut String) {
    if let Some(properties) = of["properties"].as_object() {
        table(properties, &of["required"], text);
    }
    let several = ["oneOf", "anyOf"].iter().find_map(|key| of[key].as_array());
    for each in several.into_iter().flatten() {
        let about =
            each["description"].as_str().map_or(String::new(), |d| format!(": {}", one_line(d)));
        match each["properties"].as_object() {
            Some(properties) => {
                let _ = writeln!(text, "One form{about}\n");
                table(properties, &each["required"], text);
            }
            None => {
                let _ = writeln!(text, "* {}{about}", kind(each));
            }
        }
    }
    if of["properties"].is_null() && several.is_none() {
        let _ = writeln!(text, "{}", kind(of));
    }
    text.push('\n');
}

fn table(properties: &Map<String, Value>, required: &Value, text: &mut String) {
    let needed: Vec<&str> =
        required.as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    text.push_str("| field | type | description |\n|---|---|---|\n");
    for (name, of) in properties {
        let about = of["description"].as_str().map_or(String::new(), one_line);
        let left_out = if needed.contains(&&**name) { "" } else { " Can be left out." };
        let _ = writeln!(text, "| `{name}` | {} | {about}{left_out} |", kind(of));
    }
    text.push('\n');
}

/// The type of a value in a few words.
fn kind(of: &Value) -> String {
    if let Some(there) = of["$ref"].as_str() {
        let name = there.rsplit('/').next().unwrap_or(there);
        return format!("[{name}](#{})", name.to_lowercase());
    }
    let one = |value: &Value| format!("`{value}`").replace('|', "\\|");
    if !of["const"].is_null() {
        return one(&of["const"]);
    }
    if let Some(words) = of["enum"].as_array() {
        return words.iter().map(one).collect::<Vec<_>>().join(", ");
    }
    if let Some(forms) = ["anyOf", "oneOf", "allOf"].iter().find_map(|key| of[key].as_array()) {
        return forms.iter().map(kind).collect::<Vec<_>>().join(" or ");
    }
    let named = |name: &str| match name {
        "array" => match &of["items"] {
            Value::Object(_) => format!("list of {}", kind(&of["items"])),
            _ => match of["prefixItems"].as_array() {
                Some(parts) => {
                    format!("list of {}", parts.iter().map(kind).collect::<Vec<_>>().join(" and "))
                }
                None => "list".to_owned(),
            },
        },
        "object" => match &of["additionalProperties"] {
            Value::Object(_) => format!("names with {}", kind(&of["additionalProperties"])),
            _ => "object".to_owned(),
        },
        "integer" => "whole number".to_owned(),
        "string" => "text".to_owned(),
        "boolean" => "true or false".to_owned(),
        other => other.to_owned(),
    };
    match &of["type"] {
        Value::String(name) => named(name),
        Value::Array(names) => {
            names.iter().filter_map(Value::as_str).map(named).collect::<Vec<_>>().join(" or ")
        }
        _ => "anything".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::tables;
    use serde_json::json;

    #[test]
    fn every_field_is_a_row() {
        let text = tables(&json!({
            "description": "A loop.",
            "properties": {
                "name": { "type": "string", "description": "Its\ntag:\n\n* one;\n* two." },
                "s": { "anyOf": [{ "$ref": "#/$defs/Estimate" }, { "type": "null" }] },
                "all": { "type": "array", "items": { "type": "number" } },
            },
            "required": ["name", "s"],
            "$defs": {
                "Estimate": { "properties": { "value": { "type": ["number", "null"] } }, "required": ["value"] },
                "Word": { "enum": ["a", "b"] },
            },
        }));
        for line in [
            "A loop.",
            "| `name` | text | Its tag: one; two. |",
            "| `s` | [Estimate](#estimate) or null |  |",
            "| `all` | list of number |  Can be left out. |",
            "| `value` | number or null |  |",
            "`\"a\"`, `\"b\"`",
        ] {
            assert!(text.lines().any(|each| each == line), "{line}\n{text}");
        }
    }
}
