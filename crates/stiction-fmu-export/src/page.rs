//! The page inside an FMU that documents its variables.

use stiction_fmu::{Fmi, Fmu};

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
    let mut rows = String::new();
    for variable in fmu.variables() {
        let (role, start) = (variable.role(), variable.start_text());
        rows += &format!(
            "<tr><td>{}</td><td>{role}</td><td>{start}</td><td>{}</td><td>{}</td></tr>\n",
            escaped(variable.name),
            escaped(variable.unit),
            escaped(variable.description)
        );
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{model}: {law}</title>\n<style>\n\
         body {{ font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em }}\n\
         td, th {{ padding: .2em .8em .2em 0; text-align: left; vertical-align: top }}\n\
         </style>\n</head>\n<body>\n<h1>{model}: {law}</h1>\n<p>A sticking control valve by the toolkit stiction, for \
         FMI {version}. OP and VP are in percent of span, times in seconds. {semantics}</p>\n<table>\n\
         <tr><th>variable</th><th>is</th><th>start</th><th>unit</th><th></th></tr>\n{rows}</table>\n</body>\n</html>\n"
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
