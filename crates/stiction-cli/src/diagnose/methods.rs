//! Describes the methods from the registry.

use crate::text::number;
use std::fmt::Write;
use stiction::finding::{Applies, Decides, Needs};
use stiction::methods;

/// All methods in Markdown.
pub fn table() -> String {
    let mut out = String::from(
        "# Methods\n\nMade by `stiction diagnose --methods` and checked by a test. The library's documentation, \
         module `stiction::methods`, gives equations, assumptions and limits.\n\n",
    );
    // What each method rests on, as in the documentation of the module.
    out.push_str(include_str!("../../../stiction-diagnose/src/methods/basis.md"));
    for detector in methods::all() {
        let method = detector.method();
        let applies = match method.applies {
            Applies::AnyLoop => "any loop",
            Applies::SelfRegulating => "self-regulating loops",
            Applies::Integrating => "integrating loops",
        };
        let needs = match method.needs {
            Needs::Op => "OP",
            Needs::OpAndPv => "OP and PV",
            Needs::Error => "OP and PV, and SP if it changes",
            Needs::OpAndVp => "OP and the valve position",
        };
        let decides = match method.decides {
            Decides::Stiction => "stiction",
            Decides::Nonlinearity => "nonlinearity; it has no vote",
        };
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "\n## {}\n\n`{}`\n\n* Statistic: {}\n* Rule: {}\n* Decides on {decides}\n* Family: \
             {}\n* For {applies}; needs {needs}{}\n",
            method.title,
            method.name,
            method.statistic,
            method.rule,
            method.family.name(),
            if method.explains_oscillation { ", and a detected oscillation" } else { "" },
        );
        let parameters: Vec<String> = detector
            .parameters()
            .iter()
            .map(|p| format!("{} {}", p.name, format!("{} {}", number(p.value), p.unit).trim()))
            .collect();
        if !parameters.is_empty() {
            let _ = writeln!(out, "* Parameters: {}", parameters.join(", "));
        }
        let _ = writeln!(out, "* Source: {}", method.source);
    }
    out
}
