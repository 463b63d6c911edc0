//! The keys of a TOML table, taken one by one. Keys that remain at the end are errors.
//!
//! A key that no variant of the table knows is an error at once, so that a misspelt `kc` is reported at its place and
//! not as a missing `kc`.

use serde::de::DeserializeOwned;
use std::cell::RefCell;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// A fault in a TOML text, with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong {
    pub span: Range<usize>,
    pub message: String,
}

impl From<toml::de::Error> for Wrong {
    fn from(e: toml::de::Error) -> Self {
        Self { span: e.span().unwrap_or_default(), message: e.message().to_owned() }
    }
}

/// The line, from 1, of the byte at `position`.
pub fn line_of(text: &[u8], position: usize) -> usize {
    text.iter().take(position).filter(|b| **b == b'\n').count() + 1
}

/// The keys of a table, for any kind, separated by blanks.
pub type Known = &'static str;

/// A TOML table from which keys are taken.
#[derive(Clone)]
pub struct Fields<'a, 'i> {
    table: &'a DeTable<'i>,
    /// Dotted path of the table, empty at the top.
    path: String,
    span: Range<usize>,
    /// Every known key.
    known: Known,
    /// Every requested key, given or not.
    asked: RefCell<Vec<&'static str>>,
}

type Result<T> = std::result::Result<T, Wrong>;

impl<'a, 'i> Fields<'a, 'i> {
    /// The table of a whole document, whose keys are `known`.
    pub fn document(document: &'a Spanned<DeTable<'i>>, known: Known) -> Result<Self> {
        Self::new(document.get_ref(), String::new(), document.span(), known)
    }

    fn new(table: &'a DeTable<'i>, path: String, span: Range<usize>, known: Known) -> Result<Self> {
        let fields = Self { table, path, span, known, asked: RefCell::default() };
        fields.only(known.split(' ').collect())?;
        Ok(fields)
    }

    /// An error at the first key that is not among the `known`.
    fn only(&self, mut known: Vec<&str>) -> Result<()> {
        let unknown = self.table.keys().filter(|key| !known.contains(&&**key.get_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else { return Ok(()) };
        known.sort_unstable();
        known.dedup();
        let path = self.path_of(key.get_ref());
        let message = format!("unknown key \"{path}\"; known here are {}", known.join(", "));
        Err(Wrong { span: key.span(), message })
    }

    /// The dotted path of `key`.
    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// An error at `key`, or at the table if the key is not given.
    pub fn wrong(&self, key: &str, message: impl std::fmt::Display) -> Wrong {
        let span = self.table.get(key).map_or(self.span.clone(), Spanned::span);
        Wrong { span, message: format!("{}: {message}", self.path_of(key)) }
    }

    /// An error about the table as a whole.
    pub fn wrong_table(&self, message: impl std::fmt::Display) -> Wrong {
        let message = match self.path.as_str() {
            "" => message.to_string(),
            path => format!("[{path}]: {message}"),
        };
        Wrong { span: self.span.clone(), message }
    }

    /// The core's error about this table, at the key that the error names, if any. "stem lag" is `lag`, "rest
    /// tolerance" is `rest_tolerance`.
    pub fn refused(&self, error: stiction_model::Error) -> Wrong {
        let stiction_model::Error::Parameter { name, .. } = &error else {
            return self.wrong_table(error);
        };
        let name = format!(" {}", name.to_lowercase().replace('_', " "));
        let named =
            |key: &str| name.ends_with(&format!(" {}", key.to_lowercase().replace('_', " ")));
        match self.table.keys().find(|key| named(key.get_ref())) {
            Some(key) => self.wrong(key.get_ref(), error),
            None => self.wrong_table(error),
        }
    }

    fn entry(&self, key: &'static str) -> Option<&'a Spanned<DeValue<'i>>> {
        debug_assert!(
            self.known.split(' ').any(|known| known == key),
            "{} is requested, but not known",
            key
        );
        self.asked.borrow_mut().push(key);
        self.table.get(key)
    }

    /// The value of a key as serde reads it, if given. `what` names the values that are allowed.
    fn get<T: DeserializeOwned>(&self, key: &'static str, what: &str) -> Result<Option<T>> {
        let Some(value) = self.entry(key) else { return Ok(None) };
        match T::deserialize(ValueDeserializer::from(value.clone())) {
            Ok(given) if is_finite(value.get_ref()) => Ok(Some(given)),
            _ => Err(self.wrong(key, format!("must be {what}"))),
        }
    }

    /// Whether `key` is given, without taking it.
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// A number, if given.
    pub fn number(&self, key: &'static str) -> Result<Option<f64>> {
        self.get(key, "a finite number")
    }

    /// A number, or `default` if it is not given.
    pub fn number_or(&self, key: &'static str, default: f64) -> Result<f64> {
        Ok(self.number(key)?.unwrap_or(default))
    }

    /// A number that must be given.
    pub fn required_number(&self, key: &'static str) -> Result<f64> {
        self.number(key)?.ok_or_else(|| self.wrong(key, "is missing; give a number"))
    }

    /// A whole number of at least 0, if given.
    pub fn count(&self, key: &'static str) -> Result<Option<u64>> {
        let Some(number) = self.number(key)? else { return Ok(None) };
        // Whole numbers above 2^53 would not be read exactly.
        if number >= 0.0 && number.fract() == 0.0 && number <= 9_007_199_254_740_992.0 {
            Ok(Some(number as u64))
        } else {
            Err(self.wrong(key, format!("is {number}, but must be a whole number of at least 0")))
        }
    }

    /// A text, if given.
    pub fn text(&self, key: &'static str) -> Result<Option<String>> {
        self.get(key, "a text in quotes")
    }

    /// A text or a date as written, if given.
    pub fn text_or_date(&self, key: &'static str) -> Result<Option<String>> {
        match self.entry(key).map(Spanned::get_ref) {
            Some(DeValue::Datetime(date)) => Ok(Some(date.to_string())),
            _ => self.get(key, "a date such as 2026-03-01"),
        }
    }

    /// True or false; false if it is not given.
    pub fn flag(&self, key: &'static str) -> Result<bool> {
        Ok(self.get(key, "true or false")?.unwrap_or(false))
    }

    /// One of the `choices`, or the first if the key is not given.
    pub fn choice<T: Copy>(&self, key: &'static str, choices: &[(&str, T)]) -> Result<T> {
        self.text(key)?.map_or(Ok(choices[0].1), |name| self.chosen(key, &name, choices))
    }

    /// The one of the `choices` with a name that was read at `key`.
    pub fn chosen<T: Copy>(&self, key: &str, name: &str, choices: &[(&str, T)]) -> Result<T> {
        choices.iter().find(|(known, _)| *known == name).map(|(_, value)| *value).ok_or_else(|| {
            let known: Vec<_> = choices.iter().map(|(known, _)| format!("\"{known}\"")).collect();
            self.wrong(key, format!("is \"{name}\", but must be one of {}", known.join(", ")))
        })
    }

    /// A list of numbers, if given.
    pub fn numbers(&self, key: &'static str) -> Result<Option<Vec<f64>>> {
        self.get(key, "a list of numbers")
    }

    /// Two numbers, if given.
    pub fn two(&self, key: &'static str) -> Result<Option<(f64, f64)>> {
        match self.numbers(key)?.as_deref() {
            None => Ok(None),
            Some(&[low, high]) => Ok(Some((low, high))),
            Some(_) => Err(self.wrong(key, "must be two numbers, such as [0, 100]")),
        }
    }

    /// A list of texts, if given.
    pub fn texts(&self, key: &'static str) -> Result<Option<Vec<String>>> {
        self.get(key, "a list of texts in quotes")
    }

    /// A list of pairs of numbers, if given.
    pub fn pairs(&self, key: &'static str) -> Result<Option<Vec<(f64, f64)>>> {
        let what = "a list of [time, value] pairs";
        let Some(list) = self.get::<Vec<Vec<f64>>>(key, what)? else { return Ok(None) };
        let pair = |pair: Vec<f64>| match pair[..] {
            [time, value] => Ok((time, value)),
            _ => Err(self.wrong(key, format!("must be {what}"))),
        };
        list.into_iter().map(pair).collect::<Result<_>>().map(Some)
    }

    /// A table whose keys are `known`, if given.
    pub fn table(&self, key: &'static str, known: Known) -> Result<Option<Self>> {
        self.entry(key).map(|value| self.within(key, value, known)).transpose()
    }

    /// The table that is the value at `key`.
    fn within(&self, key: &str, value: &'a Spanned<DeValue<'i>>, known: Known) -> Result<Self> {
        let path = self.path_of(key);
        match value.get_ref().as_table() {
            Some(table) => Self::new(table, path, value.span(), known),
            None => Err(self.wrong(key, format!("must be a table, [{path}]"))),
        }
    }

    /// The entries of a table with any keys, in the order of the text, each with its table; empty if the table is not
    /// given.
    fn entries(&self, key: &'static str) -> Result<Vec<(Self, &'a str, &'a Spanned<DeValue<'i>>)>> {
        let Some(value) = self.entry(key) else { return Ok(vec![]) };
        let table = value.get_ref().as_table();
        let table = table.ok_or_else(|| self.wrong(key, "must be tables, each with a name"))?;
        let all = Self { table, path: self.path_of(key), span: value.span(), ..self.clone() };
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(name, _)| name.span().start);
        let each = entries.into_iter();
        Ok(each.map(|(name, value)| (all.clone(), &**name.get_ref(), value)).collect())
    }

    /// The texts in a table with any keys, each with the table and its key.
    pub fn named_texts(&self, key: &'static str) -> Result<Vec<(Self, &'a str, &'a str)>> {
        let entry = |(table, name, value): (Self, &'a str, &'a Spanned<DeValue<'i>>)| match value
            .get_ref()
            .as_str()
        {
            Some(text) => Ok((table, name, text)),
            None => Err(table.wrong(name, "must be a text in quotes")),
        };
        self.entries(key)?.into_iter().map(entry).collect()
    }

    /// The tables within a table with any keys, each with its name. Their keys are `known`.
    pub fn named_tables(&self, key: &'static str, known: Known) -> Result<Vec<(&'a str, Self)>> {
        let entry =
            |(all, name, value): (Self, &'a str, _)| Ok((name, all.within(name, value, known)?));
        self.entries(key)?.into_iter().map(entry).collect()
    }

    /// All tables of an array of tables; none if the key is not given. A single table counts as an array of one.
    pub fn tables(&self, key: &'static str, known: Known) -> Result<Vec<Self>> {
        let Some(value) = self.entry(key) else { return Ok(vec![]) };
        let list = value.get_ref().as_array().map_or(std::slice::from_ref(value), |list| list);
        list.iter().map(|value| self.within(key, value, known)).collect()
    }

    /// Ends the reading. A key that was not requested is an error.
    pub fn finish(self) -> Result<()> {
        self.only(self.asked.take())
    }
}

/// Whether a value holds only finite numbers.
fn is_finite(value: &DeValue<'_>) -> bool {
    match value {
        DeValue::Float(float) => float.as_str().parse().is_ok_and(f64::is_finite),
        DeValue::Array(list) => list.iter().all(|item| is_finite(item.get_ref())),
        _ => true,
    }
}

/// A text as TOML writes it, on a single line.
pub fn quoted(text: &str) -> String {
    let mut out = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out += &format!("\\u{:04X}", u32::from(c)),
            c => out.push(c),
        }
    }
    out + "\""
}
