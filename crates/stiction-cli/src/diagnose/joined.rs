//! Joins recordings of one loop from several files.

use crate::files::STANDARD_INPUT;
use crate::output;
use anyhow::{Result, bail};
use std::collections::HashMap;
use std::path::Path;
use stiction::recording::Recording;
use stiction_io::join::{self, join};
use stiction_plant::overrides::{Override, Overrides, Scope};
use stiction_report::document::Source;

/// A recording and its source.
pub struct Found {
    pub source: Source,
    pub recording: Recording,
    /// Whether the file gives the tag of the loop. Otherwise the file's name is used.
    pub is_tagged: bool,
}

impl Found {
    fn pair(self) -> (Source, Recording) {
        (self.source, self.recording)
    }
}

/// Joins the recordings in `files`, two or more.
fn one(files: &[Found]) -> stiction_io::Result<(Source, Recording)> {
    let parts: Vec<join::Part<'_>> =
        files.iter().map(|each| (&*each.source.file, &each.recording)).collect();
    let mut recording = join(&parts)?;
    recording.notes.extend(not_of_the_whole(files)?);
    // The folder of the first part, where overrides are looked up.
    let file = format!("{} and {} more", files[0].source.file, files.len() - 1);
    let sha256 = join::sha256(files.iter().map(|each| &*each.source.sha256));
    Ok((Source { file, sha256 }, recording))
}

/// Notes on overrides that apply only to one of the `files` and not to the joined recording.
fn not_of_the_whole(files: &[Found]) -> stiction_io::Result<Vec<String>> {
    let mut notes = vec![];
    for Found { source, recording, .. } in files {
        if source.file == STANDARD_INPUT {
            continue;
        }
        let path = Path::new(&source.file);
        let kept = Overrides::read(&Overrides::path_for(path))?;
        let of_file = |each: &&Override| {
            each.loop_name == recording.name
                && matches!(&each.scope, Scope::File { sha256, .. }
                    if sha256.eq_ignore_ascii_case(&source.sha256))
        };
        for each in kept.all.iter().filter(of_file) {
            notes.push(format!(
                "an override in {} states that the valve {}, but only for {}, not for all files together",
                kept.origin,
                each.verdict.name(),
                source.file
            ));
        }
    }
    Ok(notes)
}

/// The recordings of each tag together, and the recordings of files without tags.
fn groups(found: Vec<Found>) -> Vec<Vec<Found>> {
    let mut groups: Vec<Vec<Found>> = vec![];
    let mut of_tag: HashMap<String, Vec<usize>> = HashMap::new();
    for each in found {
        let mut of_none = vec![];
        let own = match each.is_tagged {
            true => of_tag.entry(each.recording.name.to_ascii_lowercase()).or_default(),
            false => &mut of_none,
        };
        let is_new = |place: &&usize| {
            groups[**place].iter().all(|other| other.source.file != each.source.file)
        };
        match own.iter().find(is_new) {
            Some(place) => groups[*place].push(each),
            None => {
                own.push(groups.len());
                groups.push(vec![each]);
            }
        }
    }
    groups
}

/// Joins the recordings of each tag whose files have tags and dates. Others stay separate, with a note to the user.
pub fn by_tag(found: Vec<Found>) -> Vec<(Source, Recording)> {
    let mut all = vec![];
    for group in groups(found) {
        if group.len() > 1 {
            let (tag, files) = (group[0].recording.name.clone(), group.len());
            let apart = |why: String| {
                output::note(format!(
                    "{tag} is in {files} files and judged in each separately: {why}"
                ));
            };
            if group.iter().all(|each| each.recording.start.is_none()) {
                apart(format!(
                    "the files have no dates; if they follow each other in time, give --join --loop \"{tag}\""
                ));
            } else {
                match one(&group) {
                    Ok(joined) => {
                        all.push(joined);
                        continue;
                    }
                    Err(error) => apart(error.to_string()),
                }
            }
        }
        all.extend(group.into_iter().map(Found::pair));
    }
    all
}

/// All recordings, each separate. The user is notified of recordings of one tag that cannot be joined, such as files
/// that overlap with different values.
pub fn separate(found: Vec<Found>) -> Vec<(Source, Recording)> {
    let groups = groups(found);
    for group in groups.iter().filter(|group| group.len() > 1) {
        if group.iter().any(|each| each.recording.start.is_some())
            && let Err(error) = one(group)
        {
            let (tag, files) = (&group[0].recording.name, group.len());
            output::note(format!(
                "{tag} is in {files} files whose windows all count, although the files are not parts of one recording: {error}"
            ));
        }
    }
    groups.into_iter().flatten().map(Found::pair).collect()
}

/// Joins all recordings as one loop, at the user's request.
pub fn all(found: Vec<Found>) -> Result<Vec<(Source, Recording)>> {
    for (k, each) in found.iter().enumerate() {
        let mut own: Vec<&str> = vec![];
        for other in found.iter().filter(|other| other.source.file == each.source.file) {
            own.push(&other.recording.name);
        }
        own.dedup();
        if own.len() > 1 {
            bail!(
                "--join: {} holds {} loops, {}; choose one with --loop",
                each.source.file,
                own.len(),
                own.join(", ")
            );
        }
        let earlier = found[..k].iter().find(|other| other.is_tagged && each.is_tagged);
        if let Some(earlier) = earlier
            && !earlier.recording.name.eq_ignore_ascii_case(&each.recording.name)
        {
            bail!(
                "--join: {} is of {}, but {} of {}; join only files of one loop",
                earlier.source.file,
                earlier.recording.name,
                each.source.file,
                each.recording.name
            );
        }
    }
    if found.len() < 2 {
        return Ok(found.into_iter().map(Found::pair).collect());
    }
    let tagged = found.iter().find(|each| each.is_tagged).map(|each| each.recording.name.clone());
    let stems: Vec<Option<&str>> = found.iter().map(|each| stem(&each.recording.name)).collect();
    let shared = stems[0].filter(|_| stems.iter().all(|each| *each == stems[0]));
    let name = tagged.or(shared.map(str::to_owned));
    let (source, mut recording) = one(&found)?;
    recording.name = name.unwrap_or(recording.name);
    Ok(vec![(source, recording)])
}

/// Suggests --join where the names of files without tags begin with the same tag.
pub fn offer(found: &[Found]) {
    let untagged = || found.iter().filter(|each| !each.is_tagged);
    let mut offered: Vec<&str> = vec![];
    for each in untagged() {
        let Some(tag) = stem(&each.recording.name) else { continue };
        let same = |other: &&Found| stem(&other.recording.name) == Some(tag);
        let files: Vec<&str> = untagged().filter(same).map(|each| &*each.source.file).collect();
        if files.len() < 2 || offered.contains(&tag) {
            continue;
        }
        offered.push(tag);
        output::note(format!(
            "{} have no tag and count as {} valves; if they are successive recordings of {tag}, give --join",
            files.join(", "),
            files.len()
        ));
    }
}

/// The tag at the beginning of a file's name, such as `FIC101` of `FIC101-january` or `FIC101_2026-01-31`.
fn stem(name: &str) -> Option<&str> {
    let is_number = |part: &str| part.bytes().all(|b| b.is_ascii_digit());
    let is_tag = |name: &str| {
        let number = name.strip_suffix(|c: char| c.is_ascii_alphabetic()).unwrap_or(name);
        number.ends_with(|c: char| c.is_ascii_digit())
            && name.contains(|c: char| c.is_ascii_alphabetic())
    };
    let cut = |name: &str| name.rfind(['-', '_', ' ', '.']);
    let mut stem = &name[..cut(name)?];
    while let Some(at) = cut(stem)
        && is_number(&stem[at + 1..])
        && is_tag(&stem[..at])
    {
        stem = &stem[..at];
    }
    is_tag(stem).then_some(stem)
}

#[cfg(test)]
mod tests {
    use super::stem;

    #[test]
    fn stems_of_files() {
        for (name, expected) in [
            ("FIC101-january", Some("FIC101")),
            ("FIC101_2026-01-31", Some("FIC101")),
            ("FIC-101-january", Some("FIC-101")),
            ("U1 FIC101A.2", Some("U1 FIC101A")),
            ("FIC101", None),
            ("FIC-101", None),
            ("10-FIC-101", None),
            ("january-2", None),
        ] {
            assert_eq!(stem(name), expected, "{name}");
        }
    }
}
