//! Values of MATLAB, from a file of any version.

/// A fault, in a sentence.
pub type Message = String;

/// Names and values, in the order of the file.
pub type Fields = Vec<(String, Value)>;

/// How deep structs and cells may nest.
pub const MAX_DEPTH: usize = 48;

/// A value of MATLAB.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A matrix of numbers, column by column. An array with more dimensions has the product of all but the first as
    /// columns.
    Numbers { rows: usize, cols: usize, data: Vec<f64> },
    /// A row of characters.
    Text(String),
    /// A cell array, column by column; also the rows of a matrix of characters.
    Cell(Vec<Value>),
    /// An array of structs, most often one.
    Structs(Vec<Fields>),
    /// A value that is not read, described with an article.
    Other(String),
}

impl Value {
    /// The empty value `[]`.
    pub fn empty() -> Self {
        Self::Numbers { rows: 0, cols: 0, data: vec![] }
    }

    /// A matrix of `rows` rows, or an empty value if `data` do not fill them.
    pub fn numbers(rows: usize, data: Vec<f64>) -> Self {
        if rows == 0 || !data.len().is_multiple_of(rows) {
            return Self::empty();
        }
        Self::Numbers { rows, cols: data.len() / rows, data }
    }

    /// A matrix of characters with `rows` rows. A single row is text.
    pub fn characters(rows: usize, characters: &[char]) -> Self {
        if rows <= 1 || characters.is_empty() || !characters.len().is_multiple_of(rows) {
            return Self::Text(characters.iter().collect::<String>().trim_end().to_owned());
        }
        let row = |row: usize| {
            let text: String = characters.iter().skip(row).step_by(rows).collect();
            Self::Text(text.trim_end().to_owned())
        };
        Self::Cell((0..rows).map(row).collect())
    }

    /// An object of a class, which is never read.
    pub fn object(class: &str) -> Self {
        match class {
            "table" | "timetable" => Self::Other(format!(
                "a {class}, which only MATLAB reads (use writetable or writetimetable, or save table2struct(..., \
                 'ToScalar', true))"
            )),
            "timeseries" => Self::Other(
                "a timeseries, which only MATLAB reads (use t = x.Time; pv = x.Data; save(..., 't', 'pv', '-v7') with \
                 its name for x)"
                    .to_owned(),
            ),
            _ if class.starts_with("Simulink.") => Self::Other(format!(
                "a {class}, which only MATLAB reads (log with the save format \"Structure With Time\", or use t = \
                 x{{1}}.Values.Time; pv = x{{1}}.Values.Data; save(..., 't', 'pv', '-v7') with the name of the logged \
                 signals for x)"
            )),
            "" => Self::Other("an object".to_owned()),
            _ => Self::Other(format!("an object of class {class}")),
        }
    }
}

/// The characters of UTF-16.
pub fn utf16(units: impl Iterator<Item = u16>) -> Vec<char> {
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}
