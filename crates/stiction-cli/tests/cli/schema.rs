//! `stiction schema`: what is printed has exactly the fields that its schema describes.

use crate::{folder, paper, run, write};
use serde_json::Value;

/// Every document with commands that print it.
fn printed() -> [(&'static str, Vec<Vec<&'static str>>); 9] {
    let map = ["--map", "S=1:9:3", "J=0:4:3", "--sensitivity", "--retune"];
    [
        ("inspect", vec![vec!["inspect", "a.csv", "--json"]]),
        ("bench", vec![vec!["bench", "--simulated", "4", "--only", "verdict", "--json"]]),
        ("stem", vec![vec!["stem", "--json"]]),
        (
            "simulate",
            ["paper/closed-loop", "paper/step-linear"]
                .map(|name| vec!["simulate", name, "--json"])
                .to_vec(),
        ),
        ("compensate", vec![paper("compensate", &["--method", "knocker", "--json"])]),
        ("what-if", vec![paper("what-if", &["--json"])]),
        (
            "limit-cycle",
            vec![
                paper("limit-cycle", &["--json"]),
                [&paper("limit-cycle", &map)[..], &["--json"]].concat(),
            ],
        ),
        ("fmu-models", vec![vec!["fmu", "--list", "--json"]]),
        ("fmu-variables", vec![vec!["fmu", "--variables", "--json"]]),
    ]
}

#[test]
fn documents_are_what_their_schemas_say() {
    let folder = folder("schema");
    write(
        &folder,
        "a.csv",
        "t,op,pv,sp,mode\n0,50,20,20,auto\n1,51,20.5,20,auto\n2,52,21,20,man\n",
    );
    for (name, commands) in printed() {
        let schema = run(&folder, &["schema", name]).json();
        for command in commands {
            let document = run(&folder, &command).json();
            if let Err(why) = fits(&schema, &schema, &document) {
                panic!("{command:?} prints what the schema \"{name}\" does not describe: {why}");
            }
        }
    }
}

/// Whether a value has the type, the fields and the entries that its schema tells.
fn fits(root: &Value, schema: &Value, value: &Value) -> Result<(), String> {
    if let Some(reference) = schema["$ref"].as_str() {
        let of = root.pointer(&reference[1..]).ok_or(format!("{reference} leads nowhere"))?;
        return fits(root, of, value);
    }
    for one_of in ["anyOf", "oneOf"] {
        if let Some(choices) = schema[one_of].as_array() {
            let found = choices.iter().map(|choice| fits(root, choice, value));
            let wrong: Vec<String> = found.filter_map(Result::err).collect();
            if wrong.len() == choices.len() {
                return Err(wrong.join(", or "));
            }
        }
    }
    if !schema["type"].is_null() && !is_of(&schema["type"], value) {
        return Err(format!("{value} is no {}", schema["type"]));
    }
    for entry in value.as_array().into_iter().flatten().filter(|_| schema["items"].is_object()) {
        fits(root, &schema["items"], entry)?;
    }
    let required = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
    for name in required {
        value.get(name).ok_or(format!("{name} is missing"))?;
    }
    // A place without a type, as a schema of choices beside its fields, is looked at there.
    for (name, field) in value.as_object().into_iter().flatten() {
        let described = [&schema["properties"][name], &schema["additionalProperties"]];
        match described.into_iter().find(|of| of.is_object()) {
            Some(of) => fits(root, of, field).map_err(|why| format!("{name}: {why}"))?,
            None if schema["type"] == "object" && schema["additionalProperties"] != true => {
                return Err(format!("{name} is not described"));
            }
            None => {}
        }
    }
    Ok(())
}

/// Whether a value is of a type, or of one of several.
fn is_of(wanted: &Value, value: &Value) -> bool {
    match wanted {
        Value::Array(several) => several.iter().any(|each| is_of(each, value)),
        wanted => match wanted.as_str() {
            Some("null") => value.is_null(),
            Some("boolean") => value.is_boolean(),
            Some("integer") => value.is_u64() || value.is_i64(),
            Some("number") => value.is_number(),
            Some("string") => value.is_string(),
            Some("array") => value.is_array(),
            Some("object") => value.is_object(),
            _ => false,
        },
    }
}
