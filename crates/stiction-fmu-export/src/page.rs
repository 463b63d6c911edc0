//! The page inside an FMU that documents its variables.

use maud::{DOCTYPE, PreEscaped, html};
use stiction_fmu::{Fmi, Fmu};

const STYLE: &str = "
body { font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em }
td, th { padding: .2em .8em .2em 0; text-align: left; vertical-align: top }
";

/// The page.
pub fn page(fmu: &Fmu, fmi: Fmi) -> String {
    let (model, law) = (fmu.model(), fmu.law());
    let version = match fmi {
        Fmi::V2 => "2.0",
        Fmi::V3 => "3.0",
    };
    let semantics = match model {
        "valve" => {
            "The valve takes one sample in each communication step: OP is held over the step, and VP at its end is the \
             answer to it. S and J may be changed while the simulation runs."
        }
        "stem" => {
            "The stem is integrated over the communication step with OP held, and its events are located; nothing \
             else depends on the step."
        }
        _ => {
            "The loop plays all of its own samples that fall into the communication step, its first moment included \
             and its last not."
        }
    };
    let title = format!("{model}: {law}");
    let document = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                p {
                    "A sticking control valve by the toolkit stiction, for FMI " (version) ". OP and VP are in \
                     percent of span, times in seconds. " (semantics)
                }
                table {
                    tr { @for head in ["variable", "is", "start", "unit", ""] { th { (head) } } }
                    @for variable in fmu.variables() {
                        tr {
                            td { (variable.name) }
                            td { (variable.role()) }
                            td { (variable.start_text()) }
                            td { (variable.unit) }
                            td { (variable.description) }
                        }
                    }
                }
            }
        }
    };
    document.into_string()
}
