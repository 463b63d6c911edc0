//! MATLAB's files of version 7.3, which are HDF5.
//!
//! A struct is a group. An array is a dataset with its dimensions reversed and its class in the attribute
//! `MATLAB_class`. Cells, and the fields of arrays of structs, are references to objects in the hidden group
//! `#refs#`.

use super::links;
use super::value::{Fields, MAX_DEPTH, Message, Value, utf16};
use crate::budget::{Budget, guarded};
use hdf5_pure::{AttrValue, DType, Dataset, File, Group, Object};
use std::collections::HashMap;

/// The reason for leaving out a link to another file.
const LINK: &str = "a link to another file, which is not followed";

type Attributes = HashMap<String, AttrValue>;

/// The variables of a file.
pub(super) fn variables(bytes: &[u8]) -> Result<Fields, Message> {
    let read = || {
        let file = File::from_bytes(bytes.to_vec()).map_err(unread)?;
        let mut fields = Reader { budget: Budget::of(bytes.len()) }.fields(&file.root(), 0)?;
        fields.extend(
            links::external(bytes).into_iter().map(|name| (name, Value::Other(LINK.to_owned()))),
        );
        Ok(fields)
    };
    guarded(read).unwrap_or_else(|| Err(unread("its contents are inconsistent")))
}

/// The message for an error of HDF5.
fn unread(error: impl std::fmt::Display) -> Message {
    format!(
        "is of MATLAB's version 7.3 and cannot be read ({error}); save it with save(..., '-v7')"
    )
}

struct Reader {
    budget: Budget,
}

impl Reader {
    /// The content of a group, without MATLAB's hidden objects.
    fn fields(&mut self, group: &Group, depth: usize) -> Result<Fields, Message> {
        if depth > MAX_DEPTH {
            return Err(format!("has structs or cells nested deeper than {MAX_DEPTH}; flatten it"));
        }
        let mut fields = vec![];
        // All fields are visited in one pass, because looking up each name would need a pass of its own.
        for (name, dataset) in group.iter_datasets().map_err(unread)? {
            if !name.starts_with('#') {
                self.budget.spend(name.len() + size_of::<(String, Value)>())?;
                fields.push((name, self.dataset(&dataset, depth)?));
            }
        }
        for (name, inner) in group.iter_groups().map_err(unread)? {
            if !name.starts_with('#') {
                self.budget.spend(name.len() + size_of::<(String, Value)>())?;
                fields.push((name, self.group(&inner, depth + 1)?));
            }
        }
        Ok(fields)
    }

    fn group(&mut self, group: &Group, depth: usize) -> Result<Value, Message> {
        let attributes = group.attrs().map_err(unread)?;
        if attributes.contains_key("MATLAB_sparse") {
            return Ok(Value::Other("a sparse array".to_owned()));
        }
        if let Some(object) = object(&attributes) {
            return Ok(object);
        }
        match self.array_of_structs(group, depth)? {
            Some(structs) => Ok(structs),
            None => Ok(Value::Structs(vec![self.fields(group, depth)?])),
        }
    }

    /// The structs of an array, whose fields are datasets of references without a class.
    fn array_of_structs(&mut self, group: &Group, depth: usize) -> Result<Option<Value>, Message> {
        let datasets = group.iter_datasets().map_err(unread)?;
        if datasets.len() == 0 || group.iter_groups().map_err(unread)?.len() > 0 {
            return Ok(None);
        }
        let mut columns = vec![];
        for (name, dataset) in datasets {
            let is_plain = !dataset.attrs().map_err(unread)?.contains_key("MATLAB_class");
            if !is_plain || dataset.dtype().map_err(unread)? != DType::ObjectReference {
                return Ok(None);
            }
            columns.push((name, dataset));
        }
        let mut structs: Vec<Fields> = vec![];
        for (name, dataset) in columns {
            for (i, value) in self.references(&dataset, depth)?.into_iter().enumerate() {
                self.budget.spend(name.len() + size_of::<(String, Value)>())?;
                if structs.len() <= i {
                    structs.push(vec![]);
                }
                structs[i].push((name.clone(), value));
            }
        }
        Ok(Some(Value::Structs(structs)))
    }

    fn references(&mut self, dataset: &Dataset, depth: usize) -> Result<Vec<Value>, Message> {
        if depth > MAX_DEPTH {
            return Err(format!("has structs or cells nested deeper than {MAX_DEPTH}; flatten it"));
        }
        self.shape(dataset)?;
        let mut values = vec![];
        for object in dataset.dereference().map_err(unread)? {
            // Several references may lead to one object.
            self.budget.spend(size_of::<Value>())?;
            values.push(match object {
                Object::Group(group) => self.group(&group, depth + 1)?,
                Object::Dataset(dataset) => self.dataset(&dataset, depth + 1)?,
                _ => Value::Other("of a kind that cannot be read".to_owned()),
            });
        }
        Ok(values)
    }

    /// The number of rows of a dataset in MATLAB, and its number of cells. Refuses datasets that are too large.
    fn shape(&mut self, dataset: &Dataset) -> Result<(usize, usize), Message> {
        let shape = dataset.shape().map_err(unread)?;
        let count = shape.iter().try_fold(1u64, |product, n| product.checked_mul(*n));
        let width = dataset.datatype().map_err(unread)?.type_size();
        let bytes = count.and_then(|count| count.checked_mul(u64::from(width.max(8))));
        self.budget.spend(bytes.and_then(|n| usize::try_from(n).ok()).unwrap_or(usize::MAX))?;
        // Chunks are decompressed whole.
        let chunk = dataset.chunk_shape().map_err(unread)?.unwrap_or_default();
        let chunk = chunk.iter().fold(u64::from(width), |product, n| product.saturating_mul(*n));
        if chunk > self.budget.most() as u64 {
            return Err(unread("a chunk needs more memory than this file may use"));
        }
        let count = count.unwrap_or(0) as usize;
        let rows = match shape[..] {
            [] => 1,
            [.., rows] => rows as usize,
        };
        Ok((rows, count))
    }

    fn dataset(&mut self, dataset: &Dataset, depth: usize) -> Result<Value, Message> {
        let attributes = dataset.attrs().map_err(unread)?;
        if let Some(object) = object(&attributes) {
            return Ok(object);
        }
        let class = class(&attributes);
        let kind = dataset.dtype().map_err(unread)?;
        let is_empty = attributes.get("MATLAB_empty").and_then(AttrValue::as_i64) == Some(1);
        let (rows, count) = self.shape(dataset)?;
        if is_empty || count == 0 {
            return Ok(match class {
                "char" => Value::Text(String::new()),
                "cell" => Value::Cell(vec![]),
                "struct" => Value::Structs(vec![]),
                _ => Value::empty(),
            });
        }
        Ok(match kind {
            DType::ObjectReference => Value::Cell(self.references(dataset, depth)?),
            DType::U8 | DType::U16 | DType::U32 if class == "char" => {
                let units = dataset.read_u32().map_err(unread)?;
                let characters = utf16(units.into_iter().map(|unit| unit as u16));
                Value::characters(rows, &characters)
            }
            DType::String => match &dataset.read_string().map_err(unread)?[..] {
                [only] => Value::Text(only.trim_end().to_owned()),
                several => Value::Cell(several.iter().cloned().map(Value::Text).collect()),
            },
            DType::F32
            | DType::F64
            | DType::I8
            | DType::I16
            | DType::I32
            | DType::I64
            | DType::U8
            | DType::U16
            | DType::U32
            | DType::U64 => Value::numbers(rows, dataset.read_f64().map_err(unread)?),
            DType::Compound(_) => Value::Other("an array of complex numbers".to_owned()),
            other => Value::Other(format!("of a type that cannot be read ({other})")),
        })
    }
}

/// The MATLAB class of an object.
fn class(attributes: &Attributes) -> &str {
    attributes.get("MATLAB_class").and_then(AttrValue::as_str).unwrap_or("")
}

/// An object or function, which is not read.
fn object(attributes: &Attributes) -> Option<Value> {
    let class = class(attributes);
    let decode = attributes.get("MATLAB_object_decode").and_then(AttrValue::as_i64);
    match (class, decode.unwrap_or(0)) {
        ("function_handle", _) => Some(Value::Other("a function".to_owned())),
        (_, 0) => None,
        _ => Some(Value::object(class)),
    }
}
