//! Every advice that the product prints is followed by a test, here or elsewhere.
//!
//! Each function below lists one enum of advice without a default, so that a new variant does not compile before it has a test
//! that follows it. A test follows an advice on a simulated loop, and finds the loop better: decided, read, calm, closed. Where no
//! advice can promise that, the test asserts that the text does not.

mod plant;
mod record;
mod valve;

use stiction_diagnose::diagnose::{Cause, Fault, Mismatch, Ruling};
use stiction_diagnose::fit::prospects::Remedy;
use stiction_diagnose::recording::fitness::MeasureId;
use stiction_diagnose::valve_test::Repetition;
use stiction_diagnose::what_if::Action as WhatIfAction;
use stiction_model::closed_loop::Controller;
use stiction_model::compensate::Method;
use stiction_plant::action::Action;
use stiction_plant::log::Kind;
use stiction_plant::orders::Status;

/// How an advice is followed.
enum Way {
    /// By a test: its file from the root of the repository on, and its name.
    Test(&'static str, &'static str),
    /// A person looks at the valve itself, which no simulation does. The text names a possibility or a check and promises nothing.
    AtTheValve,
    /// It asks for nothing.
    Nothing,
}

use Way::{AtTheValve, Nothing, Test};

const RECORD: &str = "addons/stiction-plant/tests/advice/record.rs";
const VALVE: &str = "addons/stiction-plant/tests/advice/valve.rs";
const PLANT: &str = "addons/stiction-plant/tests/advice/plant.rs";
const WHAT_IF: &str = "crates/stiction-diagnose/tests/what_if.rs";
const COMMAND: &str = "crates/stiction-cli/tests/cli/plant.rs";

const BETTER_RECORD: Way = Test(RECORD, "a_recording_without_the_defect_decides");
const DECIDED_AT_THE_VALVE: Way = Test(VALVE, "a_planned_test_decides_most_open_loops");

/// Advice that is no enum of a crate below the plant.
const OTHERS: [Way; 10] = [
    // The remedies of refused files. Their enum is open, so its own crate lists it.
    Test("crates/stiction-io/src/remedy.rs", "each_remedy_helps_once_it_is_followed"),
    Test("crates/stiction-io/tests/times.rs", "every_advice_works_within_two_steps"),
    Test("crates/stiction-cli/tests/cli/reading/mutations.rs", "advice_on_spoilt_files_leads_on"),
    // `needed` with few slips, with an open position, and without a PV or a time in automatic.
    Test(VALVE, "a_test_decides_a_valve_with_few_slips"),
    Test(RECORD, "a_longer_record_decides_most_open_positions"),
    Test(RECORD, "what_lacks_the_pv_or_automatic_is_judged_with_it"),
    // `no_test`, and the order of a valve that cannot be tested.
    Test(RECORD, "a_position_decides_many_open_loops"),
    Test(
        "crates/stiction-cli/tests/cli/valve_test.rs",
        "a_signature_is_planned_performed_and_read",
    ),
    // The lab.
    Test("addons/stiction-lab/tests/lab/recordings.rs", "a_mapping_is_tried_saved_and_read_again"),
    Test(
        "addons/stiction-lab/tests/lab/exercise.rs",
        "the_lab_carries_out_the_plan_and_finds_what_is_true",
    ),
];

fn mistake(of: Mismatch) -> Way {
    match of {
        Mismatch::Exchanged
        | Mismatch::SameSignal
        | Mismatch::PvIsOp
        | Mismatch::OpIsPv
        | Mismatch::SpAndOpExchanged
        | Mismatch::SpAndPvExchanged
        | Mismatch::Unrelated => Test(RECORD, "right_columns_are_judged"),
    }
}

fn measure(of: MeasureId) -> Way {
    match of {
        MeasureId::Samples
        | MeasureId::Cycles
        | MeasureId::SamplesPerCycle
        | MeasureId::OpMoves
        | MeasureId::OpLevels
        | MeasureId::OpAtLimit
        | MeasureId::PvLevels
        | MeasureId::LongestFrozenPv
        | MeasureId::ClippedPv
        | MeasureId::CompressionFactor
        | MeasureId::PvUpdatesPerCycle
        | MeasureId::SetPoint => BETTER_RECORD,
        MeasureId::AutomaticSegment => {
            Test(RECORD, "what_lacks_the_pv_or_automatic_is_judged_with_it")
        }
        MeasureId::GoodValues
        | MeasureId::MaskedValues
        | MeasureId::BridgedSamples
        | MeasureId::DoubtfulSamples
        | MeasureId::InCommand
        | MeasureId::PvMoves
        | MeasureId::FitWindows => Nothing,
    }
}

/// What an open verdict needs, and its `confirm`.
fn ruling(of: Ruling) -> Way {
    match of {
        Ruling::Mistaken | Ruling::Strange | Ruling::Harmless | Ruling::Blind | Ruling::Open => {
            DECIDED_AT_THE_VALVE
        }
        Ruling::Sticks | Ruling::NoResponse | Ruling::Clears => Nothing,
    }
}

/// How a report distinguishes another cause, which is first ruled out.
fn cause(of: Cause) -> Way {
    match of {
        Cause::StickingValve => DECIDED_AT_THE_VALVE,
        Cause::AggressiveTuning
        | Cause::ExternalOscillation
        | Cause::ExternalWave
        | Cause::ResettingLoad => Test(PLANT, "each_action_leaves_a_loop_that_needs_none"),
        Cause::DeadZoneElsewhere => Test(VALVE, "an_inconclusive_test_decides_once_it_is_repeated"),
        Cause::Quantisation | Cause::Saturation | Cause::SetPointChanges => BETTER_RECORD,
        Cause::NoResponse | Cause::ProcessNonlinearity => AtTheValve,
        Cause::NormalOperation => Nothing,
    }
}

fn fault(of: Fault) -> Way {
    match of {
        Fault::ValveShutOrSeized
        | Fault::LineIsolated
        | Fault::AirOrSignalLost
        | Fault::SensorDead
        | Fault::HistorianStopped
        | Fault::BypassOrHandwheel => AtTheValve,
    }
}

fn repetition(of: Repetition) -> Way {
    match of {
        Repetition::ThereAndBack
        | Repetition::LongerHolds
        | Repetition::WithPosition
        | Repetition::NoAnswer
        | Repetition::LargerTurns
        | Repetition::SmallerTurns
        | Repetition::CalmerTime => Test(VALVE, "an_inconclusive_test_decides_once_it_is_repeated"),
    }
}

fn remedy(of: Remedy) -> Way {
    match of {
        Remedy::AsItIs | Remedy::Repair => Test(
            "addons/stiction-score/tests/fit.rs",
            "swings_after_a_repair_lie_in_their_intervals",
        ),
        Remedy::Retune | Remedy::RepairAndRetune | Remedy::Positioner | Remedy::Compensate(_) => {
            Test(VALVE, "a_certain_benefit_comes_when_the_action_is_taken")
        }
    }
}

fn what_if(of: &WhatIfAction) -> Way {
    match of {
        WhatIfAction::AsItIs => Test(WHAT_IF, "as_it_is_is_the_plain_simulation"),
        WhatIfAction::Repair | WhatIfAction::Compensate(_) => Test(WHAT_IF, "the_papers_loop"),
        WhatIfAction::Retune(_) => Test(WHAT_IF, "a_retuned_loop_cycles_as_predicted"),
        WhatIfAction::Positioner(_) => Test(WHAT_IF, "a_fast_positioner_divides_both_bands"),
    }
}

fn action(of: Action) -> Way {
    match of {
        Action::Repair | Action::Retune | Action::LookUpstream | Action::CheckData => {
            Test(PLANT, "each_action_leaves_a_loop_that_needs_none")
        }
        Action::Leave => Nothing,
    }
}

fn order(of: Status) -> Way {
    match of {
        Status::Open | Status::Confirmed => {
            Test(COMMAND, "a_test_confirms_an_order_and_closes_one")
        }
        Status::Closed => Nothing,
    }
}

/// What the pages of a plant let a person do about a loop.
fn entry(of: Kind) -> Way {
    match of {
        Kind::Repair | Kind::Order | Kind::Override | Kind::Note | Kind::Snooze => Test(
            "addons/stiction-lab/tests/lab/plant.rs",
            "what_is_entered_is_written_as_the_command_writes_it",
        ),
    }
}

#[test]
fn each_advice_has_a_test_that_follows_it() {
    let compensated = Method::ALL.map(Remedy::Compensate);
    let actions = [
        WhatIfAction::AsItIs,
        WhatIfAction::Repair,
        WhatIfAction::Retune(Controller::pi(1.0, 1.0).unwrap()),
        WhatIfAction::Positioner(10.0),
        WhatIfAction::Compensate(Method::Knocker),
    ];
    let remedies = [
        Remedy::AsItIs,
        Remedy::Repair,
        Remedy::Retune,
        Remedy::RepairAndRetune,
        Remedy::Positioner,
    ];
    let ways = (OTHERS.into_iter())
        .chain(Mismatch::ALL.map(mistake))
        .chain(MeasureId::ALL.iter().copied().map(measure))
        .chain(Ruling::ALL.map(ruling))
        .chain(Cause::ALL.map(cause))
        .chain(Fault::ALL.map(fault))
        .chain(Repetition::ALL.map(repetition))
        .chain(remedies.into_iter().chain(compensated).map(remedy))
        .chain(actions.iter().map(what_if))
        .chain(Action::ALL.map(action))
        .chain(Status::ALL.map(order))
        .chain(Kind::ALL.map(entry));
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    for way in ways {
        if let Test(file, name) = way {
            let source = std::fs::read_to_string(format!("{root}/{file}")).expect(file);
            assert!(source.contains(&format!("fn {name}(")), "{file} has no test {name}");
        }
    }
}
