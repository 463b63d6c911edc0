//! The keys of a TOML table, taken one by one. Keys that remain at the end are errors.
//!
//! A key that no variant of the table knows is an error at once, so that a misspelt `kc` is reported at its place and
//! not as a missing `kc`.

use std::cell::RefCell;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

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

/// A TOML table from which keys are taken.
pub struct Fields<'a, 'i> {
    table: &'a DeTable<'i>,
    /// Dotted path of the table, empty at the top.
    path: String,
    span: Range<usize>,
    /// Every known key.
    known: &'static [&'static str],
    /// Every requested key, given or not.
    asked: RefCell<Vec<&'static str>>,
}

/// A text at a key of any name.
pub struct KeyedText<'a> {
    pub text: &'a str,
    path: String,
    span: Range<usize>,
}

impl KeyedText<'_> {
    /// An error that this text is wrong.
    pub fn wrong(&self, message: impl std::fmt::Display) -> Wrong {
        Wrong { span: self.span.clone(), message: format!("{}: {message}", self.path) }
    }
}

type Result<T> = std::result::Result<T, Wrong>;

impl<'a, 'i> Fields<'a, 'i> {
    /// The table of a whole document, whose keys are `known`.
    pub fn document(
        document: &'a Spanned<DeTable<'i>>,
        known: &'static [&'static str],
    ) -> Result<Self> {
        Self::new(document.get_ref(), String::new(), document.span(), known)
    }

    fn new(
        table: &'a DeTable<'i>,
        path: String,
        span: Range<usize>,
        known: &'static [&'static str],
    ) -> Result<Self> {
        let fields = Self { table, path, span, known, asked: RefCell::default() };
        fields.only(known)?;
        Ok(fields)
    }

    /// An error at the first key that is not among the `known`.
    fn only(&self, known: &[&str]) -> Result<()> {
        let unknown = self.table.keys().filter(|key| !known.contains(&&**key.get_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else { return Ok(()) };
        let mut known = known.to_vec();
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

    /// The core's refusal of this table, at the key it names if there is one. "stem lag" is `lag`, "rest tolerance"
    /// is `rest_tolerance`.
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

    fn get(&self, key: &'static str) -> Option<&'a Spanned<DeValue<'i>>> {
        debug_assert!(self.known.contains(&key), "{} is requested, but not known", key);
        self.asked.borrow_mut().push(key);
        self.table.get(key)
    }

    /// Whether `key` is given, without taking it.
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// A number, if given.
    pub fn number(&self, key: &'static str) -> Result<Option<f64>> {
        self.get(key).map(|value| self.as_number(key, value)).transpose()
    }

    /// A number, or `default` if it is not given.
    pub fn number_or(&self, key: &'static str, default: f64) -> Result<f64> {
        Ok(self.number(key)?.unwrap_or(default))
    }

    /// A number that must be given.
    pub fn required_number(&self, key: &'static str) -> Result<f64> {
        self.number(key)?.ok_or_else(|| self.wrong(key, "is missing; give a number"))
    }

    fn as_number(&self, key: &str, value: &Spanned<DeValue<'i>>) -> Result<f64> {
        let number = match value.get_ref() {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(integer) => {
                i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|i| i as f64)
            }
            _ => None,
        };
        match number {
            Some(number) if f64::is_finite(number) => Ok(number),
            _ => Err(Wrong {
                span: value.span(),
                message: format!("{}: must be a finite number", self.path_of(key)),
            }),
        }
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
    pub fn text(&self, key: &'static str) -> Result<Option<&'a str>> {
        match self.get(key) {
            None => Ok(None),
            Some(value) => match value.get_ref().as_str() {
                Some(text) => Ok(Some(text)),
                None => Err(self.wrong(key, "must be a text in quotes")),
            },
        }
    }

    /// A text or a date as written, if given.
    pub fn text_or_date(&self, key: &'static str) -> Result<Option<String>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.get_ref() {
            DeValue::String(text) => Ok(Some(text.to_string())),
            DeValue::Datetime(date) => Ok(Some(date.to_string())),
            _ => Err(self.wrong(key, "must be a date such as 2026-03-01")),
        }
    }

    /// True or false; false if it is not given.
    pub fn flag(&self, key: &'static str) -> Result<bool> {
        match self.get(key).map(Spanned::get_ref) {
            None => Ok(false),
            Some(DeValue::Boolean(flag)) => Ok(*flag),
            Some(_) => Err(self.wrong(key, "must be true or false")),
        }
    }

    /// One of the `choices`, or the first if the key is not given.
    pub fn choice<T: Copy>(&self, key: &'static str, choices: &[(&str, T)]) -> Result<T> {
        let Some(text) = self.text(key)? else { return Ok(choices[0].1) };
        choices.iter().find(|(name, _)| *name == text).map(|(_, value)| *value).ok_or_else(|| {
            let known = choices.iter().map(|(name, _)| format!("\"{name}\"")).collect::<Vec<_>>();
            self.wrong(key, format!("is \"{text}\", but must be one of {}", known.join(", ")))
        })
    }

    /// A list of numbers, if given.
    pub fn numbers(&self, key: &'static str) -> Result<Option<Vec<f64>>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let list = value.get_ref().as_array();
        let list = list.ok_or_else(|| self.wrong(key, "must be a list of numbers"))?;
        list.iter().map(|item| self.as_number(key, item)).collect::<Result<_>>().map(Some)
    }

    /// A list of texts, if given.
    pub fn texts(&self, key: &'static str) -> Result<Option<Vec<String>>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let wrong = || self.wrong(key, "must be a list of texts in quotes");
        let list = value.get_ref().as_array().ok_or_else(wrong)?;
        let text = |item: &Spanned<DeValue<'i>>| {
            item.get_ref().as_str().map(str::to_owned).ok_or_else(wrong)
        };
        list.iter().map(text).collect::<Result<_>>().map(Some)
    }

    /// A list of pairs of numbers, if given.
    pub fn pairs(&self, key: &'static str) -> Result<Option<Vec<(f64, f64)>>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let wrong = || self.wrong(key, "must be a list of [time, value] pairs");
        let list = value.get_ref().as_array().ok_or_else(wrong)?;
        let pair = |item: &Spanned<DeValue<'i>>| {
            let pair = item.get_ref().as_array().filter(|pair| pair.len() == 2);
            let pair = pair.ok_or_else(wrong)?;
            Ok((self.as_number(key, &pair[0])?, self.as_number(key, &pair[1])?))
        };
        list.iter().map(pair).collect::<Result<_>>().map(Some)
    }

    /// A table whose keys are `known`, if given.
    pub fn table(
        &self,
        key: &'static str,
        known: &'static [&'static str],
    ) -> Result<Option<Fields<'a, 'i>>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.get_ref().as_table() {
            Some(table) => Fields::new(table, self.path_of(key), value.span(), known).map(Some),
            None => Err(self.wrong(key, format!("must be a table, [{}]", self.path_of(key)))),
        }
    }

    /// The entries of a table with any keys, in order, each one of the `choices`; none if the table is not given.
    pub fn choices<T: Copy>(
        &self,
        key: &'static str,
        choices: &[(&str, T)],
    ) -> Result<Vec<(String, T)>> {
        let entry = |(name, value): (&'a str, &'a Spanned<DeValue<'i>>)| {
            let text = value.get_ref().as_str();
            let found = choices.iter().find(|(known, _)| Some(*known) == text);
            found.map(|(_, value)| (name.to_owned(), *value)).ok_or_else(|| {
                let known: Vec<_> =
                    choices.iter().map(|(known, _)| format!("\"{known}\"")).collect();
                let is = text.map_or(String::new(), |text| format!("is \"{text}\", but "));
                let path = self.path_of(key);
                let message = format!("{path}.{name}: {is}must be one of {}", known.join(", "));
                Wrong { span: value.span(), message }
            })
        };
        self.entries(key)?.into_iter().map(entry).collect()
    }

    /// The roles in a table of columns with any keys, in order; none if the table is not given.
    pub fn entries_of_text(&self, key: &'static str) -> Result<Vec<(&'a str, KeyedText<'a>)>> {
        let entry = |(name, value): (&'a str, &'a Spanned<DeValue<'i>>)| {
            let path = format!("{}.{name}", self.path_of(key));
            match value.get_ref().as_str() {
                Some(text) => Ok((name, KeyedText { text, path, span: value.span() })),
                None => {
                    let message = format!("{path}: must be a role, such as \"op\"");
                    Err(Wrong { span: value.span(), message })
                }
            }
        };
        self.entries(key)?.into_iter().map(entry).collect()
    }

    /// The tables within a table with any keys, in order, whose keys are `known`; none if the table is not given.
    pub fn named_tables(
        &self,
        key: &'static str,
        known: &'static [&'static str],
    ) -> Result<Vec<(&'a str, Fields<'a, 'i>)>> {
        let entry = |(name, value): (&'a str, &'a Spanned<DeValue<'i>>)| {
            let path = format!("{}.{name}", self.path_of(key));
            match value.get_ref().as_table() {
                Some(table) => Ok((name, Fields::new(table, path, value.span(), known)?)),
                None => {
                    let message = format!("{path}: must be a table, [{path}]");
                    Err(Wrong { span: value.span(), message })
                }
            }
        };
        self.entries(key)?.into_iter().map(entry).collect()
    }

    /// The entries of a table in the order of the text.
    fn entries(&self, key: &'static str) -> Result<Vec<(&'a str, &'a Spanned<DeValue<'i>>)>> {
        let Some(value) = self.get(key) else { return Ok(vec![]) };
        let table = value.get_ref().as_table();
        let table = table.ok_or_else(|| self.wrong(key, "must be tables, each with a name"))?;
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(name, _)| name.span().start);
        Ok(entries.into_iter().map(|(name, value)| (&**name.get_ref(), value)).collect())
    }

    /// All tables of an array of tables; none if the key is not given. A single table counts as an array of one.
    pub fn tables(
        &self,
        key: &'static str,
        known: &'static [&'static str],
    ) -> Result<Vec<Fields<'a, 'i>>> {
        let Some(value) = self.get(key) else { return Ok(vec![]) };
        let wrong = || self.wrong(key, format!("must be tables, [[{}]]", self.path_of(key)));
        let fields = |value: &'a Spanned<DeValue<'i>>| {
            let table = value.get_ref().as_table().ok_or_else(wrong)?;
            Fields::new(table, self.path_of(key), value.span(), known)
        };
        match value.get_ref() {
            DeValue::Array(list) => list.iter().map(fields).collect(),
            _ => Ok(vec![fields(value)?]),
        }
    }

    /// Ends the reading. A key that was not requested is an error.
    pub fn finish(self) -> Result<()> {
        self.only(&self.asked.borrow())
    }
}
