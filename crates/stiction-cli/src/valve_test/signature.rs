//! The signature of a valve: `stiction test plan --signature`, and `stiction test read` of slow ramps.

use super::{Plan, Read, in_order, one_loop};
use crate::{output, text};
use anyhow::{Result, anyhow, bail};
use schemars::JsonSchema;
use serde::Serialize;
use std::process::ExitCode;
use stiction::diagnose::VerdictClass;
use stiction::recording::{GridOptions, Recording};
use stiction::spoken;
use stiction::valve_test::{
    Comparison, Signature, SignaturePlan, by_ramps, compare, signature_plan,
};
use stiction_report::document::Source;
use stiction_report::{valve_test_figure, valve_test_page, valve_test_sheet};

/// The output of `stiction test plan --signature --json`.
#[derive(Serialize, JsonSchema)]
pub struct PlanDocument {
    /// The program that wrote the document, with its version.
    tool: &'static str,
    /// The file of the recording.
    source: Source,
    /// The ramps.
    signature: SignaturePlan,
}

/// A loop with its signature.
#[derive(Serialize, JsonSchema)]
struct SignedLoop {
    /// Tag of the loop.
    name: String,
    /// The file of the recording.
    source: Source,
    /// The result of the signature.
    signature: Signature,
}

/// The output of `stiction test read --json` for a signature.
#[derive(Serialize, JsonSchema)]
pub struct ReadDocument {
    /// The program that wrote the document, with its version.
    tool: &'static str,
    /// The loop with its signature.
    loops: [SignedLoop; 1],
}

/// The output of `stiction test read --before --json` for two signatures.
#[derive(Serialize, JsonSchema)]
pub struct CompareDocument {
    /// The program that wrote the document, with its version.
    tool: &'static str,
    /// The signature before the repair.
    before: SignedLoop,
    /// The signature after it.
    after: SignedLoop,
    /// The comparison of both signatures.
    comparison: Comparison,
}

pub(super) fn planned(args: &Plan, source: Source, recording: &Recording) -> Result<()> {
    let name = &recording.name;
    let plan = signature_plan(name, [args.op_low, args.op_high])
        .map_err(|why| anyhow!("loop {name}: {}; change --op-low and --op-high", why.0))?;
    let sheet = || anyhow::Ok(valve_test_sheet::signature_html(&plan, output::TOOL));
    output::given(&args.sheet, sheet)?;
    if args.json {
        let tool = output::TOOL;
        return output::json(&PlanDocument { tool, source, signature: plan });
    }
    if output::given(&args.csv, || valve_test_sheet::signature_csv(&plan))? {
        return Ok(());
    }
    let mut out = format!("{name}: signature of the valve\n");
    for (k, text) in plan.instructions.iter().enumerate() {
        out += &text::hanging(&format!("{}. ", k + 1), text, 96);
    }
    out += &format!("ramps from {} %\n", spoken::rough(plan.from_op));
    for ramp in &plan.ramps {
        out += &format!(
            "  to {} % in {}, then hold {}\n",
            spoken::rough(ramp.to_op),
            spoken::time(ramp.duration_s),
            spoken::time(ramp.hold_s)
        );
    }
    output::text(&out)
}

/// A recording with its signature.
pub(super) struct Signed {
    source: Source,
    recording: Recording,
    signature: Signature,
}

impl Signed {
    /// The signature of a recording; `None` if it has a test with turns, or no slow ramps.
    pub(super) fn of(source: &Source, recording: &Recording) -> Option<Self> {
        let signature = by_ramps(recording, &GridOptions::default())?;
        Some(Self { source: source.clone(), recording: recording.clone(), signature })
    }

    fn page(&self) -> valve_test_page::Signed<'_> {
        let Self { source, recording, signature } = self;
        valve_test_page::Signed { source, recording, signature }
    }

    fn document(self) -> SignedLoop {
        SignedLoop { name: self.recording.name, source: self.source, signature: self.signature }
    }
}

pub(super) fn was_read(args: &Read, found: Signed) -> Result<ExitCode> {
    let bad = matches!(found.signature.class, VerdictClass::Sticks | VerdictClass::DoesNotRespond);
    match &args.before {
        Some(file) => {
            let (source, recording) = one_loop(file, args.of.of_loop.as_ref(), &args.reading)?;
            match Signed::of(&source, &recording) {
                Some(before) => was_compared(args, before, found)?,
                None => bail!(
                    "{} has no signature, but {} has one; compare two tests of the same kind",
                    file.origin(),
                    args.of.file.origin()
                ),
            }
        }
        None => was_read_alone(args, found)?,
    }
    Ok(if bad && args.fail { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

fn was_read_alone(args: &Read, found: Signed) -> Result<()> {
    let (name, page) = (&found.recording.name, found.page());
    output::plot(&args.plot, || Ok(valve_test_figure::signature(name, &page.ramped())))?;
    output::given(&args.report, || valve_test_page::signature(output::TOOL, page))?;
    if args.json {
        let loops = [found.document()];
        return output::json(&ReadDocument { tool: output::TOOL, loops });
    }
    output::text(&text::section(&page.in_brief()))
}

fn was_compared(args: &Read, before: Signed, after: Signed) -> Result<()> {
    let (old, new) = (&before.signature, &after.signature);
    in_order((&before.recording, old.from_s), (&after.recording, new.from_s))?;
    let comparison = compare(old, new);
    let pages = [before.page(), after.page()];
    output::plot(&args.plot, || {
        let [old, new] = pages.map(|page| page.ramped());
        Ok(valve_test_figure::signatures([("before", &old), ("after", &new)]))
    })?;
    output::given(&args.report, || valve_test_page::signatures(output::TOOL, pages, &comparison))?;
    if args.json {
        let (before, after) = (before.document(), after.document());
        return output::json(&CompareDocument { tool: output::TOOL, before, after, comparison });
    }
    let section = valve_test_page::compared_signatures(pages, &comparison);
    output::text(&text::section(&section))
}
