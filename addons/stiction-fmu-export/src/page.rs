//! The page inside an FMU: model, equations, an example of its behaviour, simulation, variables.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use stiction_fmu::{Fmi, Fmu};

use crate::{Error, equations, picture};

const STYLE: &str = "
body { font: 16px/1.5 sans-serif; max-width: 62em; margin: 2em auto; padding: 0 1em; color: #222 }
h1 img { height: 1.6em; vertical-align: middle; margin-right: .5em }
h2 { margin: 2em 0 .5em }
pre { background: #f4f4f4; padding: .8em 1em; overflow-x: auto; line-height: 1.45 }
figure { margin: 1em 0 } figure svg { max-width: 100%; height: auto } figcaption { color: #555 }
td, th { padding: .2em .8em .2em 0; text-align: left; vertical-align: top }
.soft { color: #555 }
";

/// The page, with its icon at `icon`, relative to the page.
pub fn page(fmu: &Fmu, fmi: Fmi, icon: &str) -> Result<String, Error> {
    let version = match fmi {
        Fmi::V2 => "2.0",
        Fmi::V3 => "3.0",
    };
    let (picture, caption) = picture::picture(fmu)?;
    let laws = equations::of(fmu.model(), fmu.law());
    let document = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                title { (fmu.title()) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { img src=(icon) alt=""; (fmu.title()) }
                p {
                    (fmu.summary()) ". By the toolkit stiction " (env!("CARGO_PKG_VERSION")) ", for FMI " (version) ": "
                    @if fmu.is_continuous() { "co-simulation and model exchange. " } @else { "co-simulation. " }
                    "OP and VP are in percent of span, times in seconds."
                }
                p { (semantics(fmu)) }
                figure { (PreEscaped(picture)) figcaption { (caption) } }
                h2 { "Equations" }
                @match fmu.model() {
                    "stem" => { pre { (equations::BALANCE) } }
                    "loop" => { pre { (equations::LOOP) } }
                    _ => {}
                }
                pre { (laws.text) }
                p class="soft" { (laws.symbols) "." }
                p { "Source: " (laws.source) "." }
                h2 { "Example" }
                p { "In Python, with " a href="https://github.com/CATIA-Systems/FMPy" { "FMPy" } ":" }
                pre { (example(fmu)) }
                p { "Details and other tools: " code { "docs/fmu.md" } " of the toolkit." }
                h2 { "Variables" }
                (variables(fmu))
                p { "Licence: MIT or Apache-2.0, see " a href="licenses/license.txt" { "licenses" } "." }
            }
        }
    };
    Ok(document.into_string())
}

/// The meaning of a step.
fn semantics(fmu: &Fmu) -> &'static str {
    match fmu.model() {
        "valve" => {
            "The valve takes one sample in each communication step: OP is held over the step, and VP at the end of the \
             step is the response to this OP. S and J may be changed while the simulation runs. The valve starts at rest at VP_start. \
             Let OP start at VP_start, too, or change VP_start."
        }
        "stem" => {
            "In co-simulation the FMU holds OP over the communication step, integrates the stem and locates its \
             events. Apart from this hold, the results do not depend on the step. The stem starts at rest at VP_start."
        }
        _ => {
            "The loop runs all of its own samples within the communication step, including a sample at the start but not \
             a sample at the end of the step."
        }
    }
}

/// A simulation in a few lines.
fn example(fmu: &Fmu) -> String {
    let (model, output) = match fmu.model() {
        "loop" => return "import fmpy\n\n\
             result = fmpy.simulate_fmu(\"loop.fmu\", stop_time=200, output=[\"PV\", \"OP\", \"VP\"])"
            .to_owned(),
        model => (model, "\"VP\", \"stuck\", \"slips\""),
    };
    format!(
        "import fmpy\nimport numpy as np\n\n\
         time = np.arange(0, 120, 0.1)\n\
         op = 50 + 25 * np.sin(2 * np.pi * time / 60)\n\
         signals = np.array(list(zip(time, op)), dtype=[(\"time\", float), (\"OP\", float)])\n\
         result = fmpy.simulate_fmu(\"{model}.fmu\", fmi_type=\"CoSimulation\", stop_time=119.9, step_size=0.1,\n    \
         output_interval=0.1, input=signals, output=[{output}])"
    )
}

fn variables(fmu: &Fmu) -> Markup {
    html! {
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
