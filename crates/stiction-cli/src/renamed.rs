//! Former names of options, which still work, with a note.

use std::ffi::OsString;

/// Command, former name of the option, and present name.
const RENAMED: [(&str, &str, &str); 3] = [
    ("figures", "--out", "--output"),
    ("bench", "--html", "--report"),
    ("stem", "--with", "--set"),
];

/// The arguments with present names of options, and notes on former names.
pub fn present(arguments: impl IntoIterator<Item = OsString>) -> (Vec<OsString>, Vec<String>) {
    let mut all: Vec<OsString> = arguments.into_iter().collect();
    let mut notes = vec![];
    let command =
        all.iter().skip(1).filter_map(|word| word.to_str()).find(|word| !word.starts_with('-'));
    let Some(command) = command.map(str::to_owned) else { return (all, notes) };
    for k in 1..all.len() {
        let Some(word) = all[k].to_str() else { continue };
        let (name, value) =
            word.split_once('=').map_or((word, None), |(name, value)| (name, Some(value)));
        let next = all.get(k + 1).and_then(|next| next.to_str());
        // A set of parameters was once named with the option that now changes a parameter.
        let named = value.or(next).is_some_and(|value| !value.contains('='));
        let now = match RENAMED.iter().find(|(of, was, _)| *of == command && *was == name) {
            Some((.., now)) => now,
            None if command == "stem" && name == "--set" && named => "--parameters",
            None => continue,
        };
        notes.push(format!("{name} of stiction {command} is now called {now}"));
        let written = value.map_or(now.to_owned(), |value| format!("{now}={value}"));
        all[k] = written.into();
    }
    (all, notes)
}

#[cfg(test)]
mod tests {
    use super::present;

    fn of(line: &str) -> (String, usize) {
        let (all, notes) = present(line.split(' ').map(Into::into));
        let words: Vec<&str> = all.iter().filter_map(|word| word.to_str()).collect();
        (words.join(" "), notes.len())
    }

    #[test]
    fn former_names_are_read_as_the_present_ones() {
        for (was, is, notes) in [
            ("stiction figures --out x", "stiction figures --output x", 1),
            ("stiction --quiet bench --html=a.html", "stiction --quiet bench --report=a.html", 1),
            ("stiction stem --set cts --with a=1", "stiction stem --parameters cts --set a=1", 2),
            ("stiction stem --set a=1", "stiction stem --set a=1", 0),
            ("stiction diagnose --out x", "stiction diagnose --out x", 0),
            ("stiction", "stiction", 0),
        ] {
            assert_eq!(of(was), (is.to_owned(), notes));
        }
    }
}
