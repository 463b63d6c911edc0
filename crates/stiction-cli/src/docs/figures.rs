//! The page of the paper's figures, drawn as `stiction figures` draws them.

use crate::paper;
use anyhow::Result;
use rayon::prelude::*;
use std::fmt::Write as _;
use stiction_docs::markdown::literal;
use stiction_docs::{File, Page, contents};

/// The page and its figures. `done` is called after each figure.
pub fn page(done: impl Fn() + Sync) -> Result<(Page, Vec<File>)> {
    let drawn: Vec<(paper::Drawn, String)> = paper::FIGURES
        .par_iter()
        .map(|make| {
            let drawn = make()?;
            let svg = drawn.figure.svg()?;
            done();
            Ok((drawn, svg))
        })
        .collect::<Result<_>>()?;
    let mut text = format!("# The paper, figure by figure\n\n{}\n", literal(paper::INTRODUCTION));
    let mut files = vec![];
    for (drawn, svg) in drawn {
        let path = format!("paper/{}.svg", drawn.name);
        let caption = literal(&drawn.figure.caption);
        let _ = write!(
            text,
            "\n## {}\n\n![{caption}]({path})\n\n{caption}\n\nSimulate this:\n\n```sh\n{}\n```\n\n\
            <details><summary>Parameters</summary>\n\n| parameter | value | unit |\n|---|---|---|\n",
            literal(&drawn.heading),
            drawn.command,
        );
        for (name, value, unit) in &drawn.parameters {
            let _ =
                writeln!(text, "| {} | {} | {} |", literal(name), literal(value), literal(unit));
        }
        text += "\n</details>\n";
        files.push(File::new(path, svg));
    }
    Ok((Page::new(contents::PAPER, "The paper", text), files))
}
