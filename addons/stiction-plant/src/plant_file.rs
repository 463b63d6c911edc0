//! `plant.toml`: the facts about a plant, in one file.

use crate::error::{Error, Result, file};
use serde::Deserialize;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::Path;
use stiction_diagnose::recording::{LoopType, Mode};
use stiction_io::options::{LoopOptions, LoopSettings, Mapped};
use stiction_io::role::{Role, Signal};
use stiction_io::timestamp::Zone;
use stiction_io::{ReadOptions, Remedy, Wording};

/// What the file is called.
pub const NAME: &str = "plant.toml";

/// A plant as described by its file.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantFile {
    /// Name of the plant.
    pub name: String,
    /// Time zone of its clock, such as `Europe/Berlin`. Days begin at midnight of this zone, and times without a zone
    /// are interpreted in it.
    #[serde(default = "utc")]
    pub zone: String,
    /// Data files, as patterns such as `export/*.parquet`, relative to the folder of the plant.
    #[serde(default)]
    pub data: Vec<String>,
    /// How tags are built, such as `{loop}.{signal}`.
    pub pattern: Option<String>,
    /// The longest time to judge a window of a loop, s; [`TIME_LIMIT_S`](crate::scan::TIME_LIMIT_S) by default.
    pub time_limit_s: Option<u32>,
    /// The largest detection limit of a valve that is fine, percent of span;
    /// [`FINE_UP_TO`](stiction_diagnose::diagnose::FINE_UP_TO) by default.
    pub fine_up_to: Option<f64>,
    /// Meaning of the words and codes of mode tags.
    #[serde(default)]
    pub modes: BTreeMap<String, ModeName>,
    /// The areas.
    #[serde(default)]
    pub area: BTreeMap<String, Area>,
    /// The loops with known facts. Other loops in the data are judged, too.
    #[serde(default, rename = "loop")]
    pub loops: BTreeMap<String, LoopFacts>,
}

/// A mode, as the file names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ModeName {
    /// Automatic.
    Auto,
    /// Cascade.
    Cascade,
    /// Manual.
    Manual,
    /// Something else.
    Other,
}

/// The known facts about an area.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Area {
    /// Weight, 1 by default.
    pub weight: Option<f64>,
}

/// The known facts about a loop.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoopFacts {
    /// Tag or column of the process value.
    pub pv: Option<String>,
    /// Tag or column of the controller output.
    pub op: Option<String>,
    /// Tag or column of the set point.
    pub sp: Option<String>,
    /// Tag or column of the valve position.
    pub vp: Option<String>,
    /// Tag or column of the mode.
    pub mode: Option<String>,
    /// What it controls.
    #[serde(rename = "type")]
    pub loop_type: Option<String>,
    /// The values of OP that are 0 % and 100 %. By default they are estimated from each file.
    pub op_range: Option<[f64; 2]>,
    /// The values of PV that are 0 % and 100 %.
    pub pv_range: Option<[f64; 2]>,
    /// The values of VP that are 0 % and 100 %. By default they are estimated from each file.
    pub vp_range: Option<[f64; 2]>,
    /// Weight, 1 by default.
    pub weight: Option<f64>,
    /// The area it is in, one of `[area]`.
    pub area: Option<String>,
    /// The unit it is in.
    pub unit: Option<String>,
    /// Loops whose oscillation would reach it.
    #[serde(default)]
    pub upstream: Vec<String>,
    /// Whether it is on the watch list.
    #[serde(default)]
    pub watch: bool,
}

fn utc() -> String {
    "UTC".to_owned()
}

/// A plant file that was read, with the settings derived from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// The content of the file.
    pub file: PlantFile,
    /// The zone of the plant.
    pub zone: Zone,
    /// How its data are read.
    pub options: ReadOptions,
}

/// The meaning of a mode as the file writes it.
pub(crate) const WORDING: Wording = Wording(|remedy| match remedy {
    Remedy::Mode { word, modes } => {
        format!("\"{word}\" = \"{}\" below [modes]", modes.join("\" or \""))
    }
    other => other.to_string(),
});

impl Plant {
    /// Reads `plant.toml` in `folder`.
    ///
    /// # Errors
    /// If the file does not exist or names no data, or as for [`Plant::parse`].
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(NAME);
        let text = std::fs::read_to_string(&path).map_err(file(&path))?;
        let origin = path.display().to_string();
        let plant = Self::parse(&text, &origin)?;
        if plant.file.data.is_empty() {
            let problem = format!(
                "line {}, data: names no files; give patterns, as in [\"export/*.parquet\"]",
                line_of(&text, "", "data")
            );
            return Err(Error::PlantFile { origin, problems: vec![problem] });
        }
        Ok(plant)
    }

    /// Reads a plant file from its `text`. Errors name it `origin`. It need not name data, which may come as tables.
    ///
    /// # Errors
    /// If the text is not well-formed, or has unknown keys or invalid values. Every problem is listed with its line.
    pub fn parse(text: &str, origin: &str) -> Result<Self> {
        let refused = |problems| Error::PlantFile { origin: origin.to_owned(), problems };
        let file: PlantFile = toml::from_str(text).map_err(|e| {
            let at = e.span().map_or(0, |span| span.start);
            let line =
                text.as_bytes()[..at.min(text.len())].iter().filter(|b| **b == b'\n').count();
            refused(vec![format!("line {}: {}", line + 1, e.message().trim())])
        })?;
        let mut problems = vec![];
        let mut problem = |heading: &str, key: &str, message: String| {
            let line = line_of(text, heading, key);
            let path = if heading.is_empty() { key.to_owned() } else { format!("{heading}.{key}") };
            problems.push((line, format!("line {line}, {path}: {message}")));
        };
        let mut options = ReadOptions { wording: WORDING, ..ReadOptions::default() };
        let zone = file.zone.parse::<Zone>().map_err(|e| problem("", "zone", e)).ok();
        options.zone.clone_from(&zone);
        if let Some(pattern) = &file.pattern {
            match pattern.parse() {
                Ok(pattern) => options.pattern = Some(pattern),
                Err(e) => problem("", "pattern", e),
            }
        }
        if !file.fine_up_to.is_none_or(|limit| limit > 0.0 && limit <= 100.0) {
            problem("", "fine_up_to", "must be a percentage of span above 0, up to 100".to_owned());
        }
        if file.time_limit_s == Some(0) {
            problem("", "time_limit_s", "must be a whole number of seconds above 0".to_owned());
        }
        for pattern in &file.data {
            if let Err(e) = glob::Pattern::new(pattern) {
                problem("", "data", format!("\"{pattern}\" is not a valid file pattern: {e}"));
            }
        }
        let is_weight = |weight: Option<f64>| weight.is_none_or(|w| w > 0.0 && w.is_finite());
        let no_weight = || "must be a number above 0".to_owned();
        for (name, area) in &file.area {
            if !is_weight(area.weight) {
                problem(&format!("area.{name}"), "weight", no_weight());
            }
        }
        for (name, facts) in &file.loops {
            let heading = format!("loop.{name}");
            if !is_weight(facts.weight) {
                problem(&heading, "weight", no_weight());
            }
            if let Some(area) = facts.area.as_ref().filter(|area| !file.area.contains_key(*area)) {
                problem(
                    &heading,
                    "area",
                    format!("there is no area \"{area}\"; add [area.{area}]"),
                );
            }
            for other in facts.upstream.iter().filter(|other| !file.loops.contains_key(*other)) {
                problem(
                    &heading,
                    "upstream",
                    format!("there is no [loop.{other}]; add it, or remove it here"),
                );
            }
            for (key, range) in facts.ranges() {
                if range
                    .is_some_and(|[low, high]| !(low < high && low.is_finite() && high.is_finite()))
                {
                    let rule = "must be two numbers, the lower first, such as [0, 100]";
                    problem(&heading, key, rule.to_owned());
                }
            }
            let loop_type = facts.loop_type.as_deref().map(LoopType::by_name).transpose();
            let loop_type = loop_type.map_err(|e| problem(&heading, "type", e.to_string()));
            options.loops.push(LoopOptions {
                name: name.clone(),
                settings: LoopSettings {
                    loop_type: loop_type.ok().flatten(),
                    op_range: facts.op_range.map(Into::into),
                    pv_range: facts.pv_range.map(Into::into),
                    vp_range: facts.vp_range.map(Into::into),
                },
            });
            options.map.extend(facts.tags().map(|(signal, column)| Mapped {
                loop_name: Some(name.clone()),
                role: Role::Signal(signal),
                column: column.to_owned(),
            }));
        }
        options.modes =
            file.modes.iter().map(|(word, mode)| (word.clone(), (*mode).into())).collect();
        problems.sort();
        match zone {
            Some(zone) if problems.is_empty() => Ok(Self { file, zone, options }),
            _ => Err(refused(problems.into_iter().map(|(_, problem)| problem).collect())),
        }
    }

    /// The known facts about a loop. Names are compared without case.
    pub fn facts(&self, name: &str) -> Option<&LoopFacts> {
        let same = |known: &&String| known.to_lowercase() == name.to_lowercase();
        self.file.loops.keys().find(same).map(|known| &self.file.loops[known])
    }

    /// SHA-256 of the settings that affect the verdict of any loop: the zone, how tags and modes are read, and the tags and types of all
    /// loops. Areas, weights and the like can change without judging again.
    pub fn reading_hash(&self) -> String {
        let file = &self.file;
        let tags: Vec<_> =
            file.loops.iter().map(|(name, facts)| (name, facts.of_reading())).collect();
        hash(&format!("{:?}", (&file.zone, &file.pattern, &file.modes, tags)))
    }

    /// SHA-256 of the settings that affect the verdict of this loop, including the model of the verdict.
    pub fn settings_hash(&self, name: &str) -> String {
        let file = &self.file;
        let facts = self.facts(name);
        let own = facts.map(LoopFacts::of_reading);
        let model = crate::store::window::model_version();
        hash(&format!(
            "{:?}",
            (&file.zone, &file.pattern, &file.modes, own, model, file.fine_up_to)
        ))
    }
}

/// A SHA-256 in hexadecimal.
pub(crate) fn hash(text: &str) -> String {
    format!("{:x}", Sha256::digest(text))
}

impl LoopFacts {
    fn ranges(&self) -> [(&'static str, Option<[f64; 2]>); 3] {
        [("op_range", self.op_range), ("pv_range", self.pv_range), ("vp_range", self.vp_range)]
    }

    /// The settings that affect how the loop is read and judged.
    fn of_reading(&self) -> impl std::fmt::Debug {
        (self.tags().collect::<Vec<_>>(), &self.loop_type, self.ranges())
    }

    /// The tags in the file.
    pub fn tags(&self) -> impl Iterator<Item = (Signal, &str)> {
        let all = [
            (Signal::Op, &self.op),
            (Signal::Pv, &self.pv),
            (Signal::Sp, &self.sp),
            (Signal::Vp, &self.vp),
            (Signal::Mode, &self.mode),
        ];
        all.into_iter().filter_map(|(signal, tag)| Some((signal, tag.as_deref()?)))
    }
}

impl From<ModeName> for Mode {
    fn from(name: ModeName) -> Self {
        match name {
            ModeName::Auto => Self::Automatic,
            ModeName::Cascade => Self::Cascade,
            ModeName::Manual => Self::Manual,
            ModeName::Other => Self::Other,
        }
    }
}

/// The line, from 1, of `key` below the table `heading`, or of the heading; 1 if neither is found.
fn line_of(text: &str, heading: &str, key: &str) -> usize {
    let bare = |line: &str| line.replace(['"', '\'', ' '], "");
    let wanted = format!("[{}]", bare(heading));
    let inline = format!("{}=", bare(heading));
    let (mut within, mut at) = (heading.is_empty(), 1);
    for (k, line) in text.lines().enumerate() {
        let line = bare(line);
        if line.starts_with('[') && !heading.is_empty() {
            within = line.starts_with(&wanted);
        }
        if line.starts_with(&wanted) || (!heading.is_empty() && line.starts_with(&inline)) {
            at = k + 1;
        }
        if within && line.starts_with(&format!("{key}=")) {
            return k + 1;
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: &str = r#"
name = "North"
zone = "Europe/Berlin"
data = ["export/*.parquet"]
pattern = "{loop}.{signal}"
[modes]
"3" = "auto"
[area.Distillation]
weight = 3
[loop.FIC101]
pv = "10FT101.DACA.PV"
op = "10FC101.PIDA.OP"
type = "flow"
area = "Distillation"
weight = 5
unit = "C-101"
upstream = ["PIC104"]
watch = true
[loop.PIC104]
"#;

    #[test]
    fn everything_is_read() {
        let plant = Plant::parse(ALL, "plant.toml").unwrap();
        assert_eq!((plant.options.map.len(), plant.options.modes.len()), (2, 1));
        assert_eq!(plant.facts("fic101").unwrap().weight, Some(5.0));
        let lighter = Plant::parse(&ALL.replace("weight = 5", "weight = 4"), "p").unwrap();
        assert_eq!(lighter.settings_hash("FIC101"), plant.settings_hash("FIC101"));
        let other = Plant::parse(&ALL.replace("\"flow\"", "\"level\""), "p").unwrap();
        assert_ne!(other.settings_hash("FIC101"), plant.settings_hash("FIC101"));
        assert_eq!(other.settings_hash("PIC104"), plant.settings_hash("PIC104"));
    }

    #[test]
    fn mistakes_are_all_named_with_their_lines() {
        let told = |text: &str| Plant::parse(text, "plant.toml").unwrap_err().to_string();
        for (from, to, expected) in [
            (
                "weight = 5",
                "op_range = [9, 0]",
                "plant.toml, line 15, loop.FIC101.op_range: must be two",
            ),
            ("pv = ", "pw = ", "plant.toml, line 11: unknown field `pw`"),
            ("\"auto\"", "\"car\"", "plant.toml, line 7: unknown variant `car`"),
            (
                "weight = 5",
                "weight = 0",
                "plant.toml, line 15, loop.FIC101.weight: must be a number above 0",
            ),
            ("{signal}", "x", "plant.toml, line 5, pattern: "),
            ("[modes]", "fine_up_to = 0\n[modes]", "plant.toml, line 6, fine_up_to: must be"),
            ("[modes]", "time_limit_s = 0\n[modes]", "plant.toml, line 6, time_limit_s: must be"),
        ] {
            let message = told(&ALL.replace(from, to));
            assert!(message.starts_with(expected), "{message}");
        }
        let several =
            ALL.replace("Europe/", "").replace("\"flow\"", "\"flo\"").replace("[loop.PIC104]", "");
        let message = told(&several);
        assert_eq!(message.lines().count(), 3, "{message}");
        assert!(
            message.contains("line 3, zone") && message.contains("line 13, loop.FIC101.type"),
            "{message}"
        );
        assert!(
            message.contains("line 17, loop.FIC101.upstream: there is no [loop.PIC104]"),
            "{message}"
        );
    }
}
