//! The part of JSON for parameters: one flat object of texts, numbers and Booleans.

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Text(String),
    Number(f64),
    Boolean(bool),
}

/// Reads one flat object.
pub(crate) fn read(text: &str) -> Result<Vec<(String, Value)>, String> {
    let mut rest = Rest { text, at: 0 };
    let mut pairs: Vec<(String, Value)> = vec![];
    rest.expect('{')?;
    if !rest.take('}') {
        loop {
            let key = rest.string()?;
            if pairs.iter().any(|(known, _)| *known == key) {
                return Err(format!("\"{key}\" occurs twice"));
            }
            rest.expect(':')?;
            let value = rest.value(&key)?;
            pairs.push((key, value));
            if !rest.take(',') {
                break;
            }
        }
        rest.expect('}')?;
    }
    rest.space();
    if rest.left().is_empty() {
        Ok(pairs)
    } else {
        Err(format!("nothing may follow the closing }}, but there is {}", rest.sight()))
    }
}

struct Rest<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Rest<'a> {
    fn left(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or_default()
    }

    /// The next character, for messages.
    fn sight(&self) -> String {
        let line = self.text.get(..self.at).unwrap_or_default().matches('\n').count() + 1;
        match self.left().chars().next() {
            Some(next) => format!("{next:?} in line {line}"),
            None => "the end of the text".to_owned(),
        }
    }

    fn space(&mut self) {
        let left = self.left();
        self.at += left.len() - left.trim_start_matches([' ', '\t', '\r', '\n']).len();
    }

    fn take(&mut self, c: char) -> bool {
        self.space();
        let found = self.left().starts_with(c);
        self.at += if found { c.len_utf8() } else { 0 };
        found
    }

    fn expect(&mut self, c: char) -> Result<(), String> {
        if self.take(c) { Ok(()) } else { Err(format!("expected {c:?}, found {}", self.sight())) }
    }

    fn string(&mut self) -> Result<String, String> {
        self.expect('"')?;
        let left = self.left();
        let end = left.find(['"', '\\', '\n']).unwrap_or(left.len());
        if !left[end..].starts_with('"') {
            self.at += end;
            return Err(format!(
                "a text must end with '\"' on its line and hold no escapes, but there is {}",
                self.sight()
            ));
        }
        self.at += end + 1;
        Ok(left[..end].to_owned())
    }

    fn value(&mut self, key: &str) -> Result<Value, String> {
        self.space();
        let left = self.left();
        if left.starts_with('"') {
            return self.string().map(Value::Text);
        }
        let end = left.find([',', '}', ' ', '\t', '\r', '\n']).unwrap_or(left.len());
        let word = &left[..end];
        let value = match word {
            "true" => Value::Boolean(true),
            "false" => Value::Boolean(false),
            _ => match word.parse::<f64>() {
                Ok(value) if value.is_finite() && is_number(word) => Value::Number(value),
                _ => {
                    return Err(format!(
                        "\"{key}\" must be a text, a finite number, true or false, but there is {}",
                        self.sight()
                    ));
                }
            },
        };
        self.at += end;
        Ok(value)
    }
}

/// Whether it is a JSON number: parsing also accepts words, and signs and points in other places.
fn is_number(word: &str) -> bool {
    let digits = word.strip_prefix('-').unwrap_or(word);
    digits.starts_with(|c: char| c.is_ascii_digit())
        && digits.chars().all(|c| c.is_ascii_digit() || "+-.eE".contains(c))
}

#[cfg(test)]
mod tests {
    use super::{Value, read};

    #[test]
    fn reads_flat_objects() {
        let pairs = read(" { \"a\" : 1.5e-3 , \"b\":true,\"c\" : \"two-phase\"}\n").unwrap();
        assert_eq!(
            pairs,
            [
                ("a".to_owned(), Value::Number(1.5e-3)),
                ("b".to_owned(), Value::Boolean(true)),
                ("c".to_owned(), Value::Text("two-phase".to_owned())),
            ]
        );
        assert_eq!(read("{}").unwrap(), []);
    }

    #[test]
    fn refuses_all_else_in_a_sentence() {
        for (text, says) in [
            ("", "expected '{', found the end of the text"),
            ("[]", "expected '{', found '[' in line 1"),
            ("{\"a\": 1,}", "expected '\"', found '}' in line 1"),
            ("{\"a\": 1, \"a\": 2}", "\"a\" occurs twice"),
            ("{\"a\": nan}", "\"a\" must be a text, a finite number"),
            ("{\"a\": 1e999}", "\"a\" must be a text, a finite number"),
            ("{\"a\": +1}", "\"a\" must be a text, a finite number"),
            ("{\"a\": .5}", "\"a\" must be a text, a finite number"),
            ("{\"a\": [1]}", "\"a\" must be a text, a finite number"),
            ("{\"a\": null}", "\"a\" must be a text, a finite number"),
            ("{\"a\": 1} x", "nothing may follow the closing }"),
            ("{\"a", "a text must end with '\"'"),
            ("{\"a\\n\": 1}", "hold no escapes"),
            ("{\"a\"\n: 1\n", "expected '}', found the end of the text"),
        ] {
            let found = read(text).unwrap_err();
            assert!(found.contains(says), "{text:?}: {found}");
        }
    }
}
