//! What is in a suite, in words.

use crate::scoreboard::KnownLoop;
use crate::suite::Suite;
use std::collections::BTreeMap;
use stiction_report::report::layout::Table;

/// Name of the file of recordings.
pub const RECORDINGS: &str = "recordings.jsonl";
/// Name of the file of the truth.
pub const TRUTH: &str = "truth.csv";

/// The datasheet of a suite in Markdown.
pub fn markdown(suite: &Suite, asked: &[KnownLoop], tool: &str) -> String {
    let half = if suite.is_hidden() { ", hidden half" } else { "" };
    let mut out = format!(
        "# Suite {}{half}\n\nSimulated control loops with known truth: {}. Written by {tool} from population {}. The same \
         command gives the same bytes on every machine.\n\n",
        suite.name(),
        suite.about(),
        stiction_population::VERSION
    );
    out += &format!(
        "* `{RECORDINGS}`: one recording a line, as JSON. Keys are `id`, `type` (of the loop, such as `flow`), \
         `sample_time_s` (s), `op` (controller output, percent), `pv` (process value), `sp` (set point, in the units of \
         the PV) and `vp` (valve position, percent). Signals that are not recorded are absent, and missing samples are \
         null. Neither names nor order indicate the kind of a loop.\n\
         * `truth/{TRUTH}`: one row per loop with its kind, whether its valve sticks, whether the record can show this, \
         S and J. Do not give this file to a detector.\n\
         * `SHA256SUMS`: the SHA-256 of each file, as `sha256sum -c` reads it.\n\n\
         No recording of a real plant is included. The loops may be used for any purpose under the licences of the \
         program, MIT or Apache 2.0. Their distributions were chosen by judgement, not from statistics of plants. \
         `docs/population.md` of the project describes them.\n\n## Parts\n\n"
    );
    let table = Table::new("").words("part").numbers("loops", "").words("content");
    let parts = suite.parts().iter().fold(table, |table, (part, n)| {
        table.row([part.name().to_owned(), n.to_string(), part.about().to_owned()])
    });
    out += &parts.markdown();
    out += "\n## Kinds\n\nStiction is masked if the record cannot show it. Masked loops belong to no class.\n\n";
    let mut kinds: BTreeMap<(bool, &str), (usize, usize)> = BTreeMap::new();
    for each in asked {
        let row = kinds.entry((!each.truth.sticks, &each.truth.kind)).or_default();
        row.0 += 1;
        row.1 += usize::from(!each.counts());
    }
    let table =
        Table::new("").words("kind").words("valve").numbers("loops", "").numbers("masked", "");
    let kinds = kinds.into_iter().fold(table, |table, ((healthy, kind), (n, masked))| {
        let state = if healthy { "healthy" } else { "sticks" };
        table.row([kind.to_owned(), state.to_owned(), n.to_string(), masked.to_string()])
    });
    out += &kinds.markdown();
    out += "\n## Properties\n\nA loop may have several historians. Loops outside the population have only the \
            properties \"part\" and \"samples\".\n\n";
    let mut groups: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for (property, value) in asked.iter().flat_map(|each| &each.groups) {
        *groups.entry((property, value)).or_default() += 1;
    }
    let table = Table::new("").words("property").words("value").numbers("loops", "");
    let groups = groups
        .into_iter()
        .fold(table, |table, ((property, value), n)| table.row([property, value, &n.to_string()]));
    out + &groups.markdown()
}
