"""Results of a diagnosis, with the descriptions of its JSON schema.

Made by `python3 docs/python_api.py` from `docs/diagnosis.schema.json` and checked by a test.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from stiction._result import Result, about, result
from stiction.detection import Finding
from stiction.oscillations import Oscillation
from stiction.recordings import Fitness

__all__ = [
    "Alternative",
    "Definition",
    "Estimate",
    "Fault",
    "FewSlips",
    "Judged",
    "Kpi",
    "Limit",
    "Masked",
    "Mended",
    "NoResponse",
    "PlantTime",
    "Relation",
    "Rest",
    "SignalRange",
    "Stiction",
    "TestPlan",
    "Turn",
    "ValveChange",
    "Verdict",
    "Votes",
    "Window",
]


@result
class Found(Result):
    """The diagnosis of one loop."""

    name: str = about("Tag of the loop.")
    loop_type: str = about("The controlled quantity.")
    verdict: Verdict = about("The conclusion.")
    stiction: Stiction = about("Size of the stiction.")
    oscillation: Oscillation | None = about(
        "The dominant oscillation of the loop, with times on the recording's clock; None without a segment to judge."
    )
    judged: Judged | None = about("The judged segment, the longest of the grid; None if there is none.")
    plant_time: PlantTime = about("The clock of the plant, in which its times are shown.")
    repairs: list[Mended] = about("Repairs of the data.")
    masked: list[Masked] = about("Values that are no measurements and count as missing, of the whole recording.")
    op_range: SignalRange | None = about(
        "The values of OP at 0 % and 100 %, with all plausible spans; None if the OP is in percent."
    )
    fitness: Fitness = about("Fitness of the data.")
    findings: dict[str, Finding] = about("The finding of each method that was run, in the order of the registry.")
    kpis: dict[str, Kpi] = about("Key figures of the loop.")
    relation: Relation | None = about("The likely mistake in the columns; None if OP and PV seem to belong together.")
    no_response: NoResponse | None = about("The behaviour of a PV that does not respond; None if it seems to respond.")
    few_slips: FewSlips | None = about(
        "Number of slips missing from a record that looks stuck; None if it does not, or has enough."
    )
    windows: list[Window] = about("The windows of the judged segment that were weighed one by one, in order of time.")
    notes: list[str] = about("Remarks to the user by the reader of the file or another step.")

    _documented_as: ClassVar[Mapping[str, str]] = {
        "name": "loop",
        "loop_type": "type",
        "findings": "detectors",
    }


@result
class Judged(Result):
    """The part of a recording that was judged."""

    from_s: float = about("Time of its first sample, s on the recording's clock.")
    duration_s: float = about("Its duration, s.")
    sample_time_s: float = about("Time between samples, s.")
    samples: int = about("Number of samples.")
    bridged: int = about("Number of bridged samples.")
    segments: int = about("Number of segments of the grid.")
    signals: list[str] = about("The recorded signals.")


@result
class PlantTime(Result):
    """The clock for the instants of a recording: that of the plant at the beginning. A recording across a change to
    or from summer time keeps it, so that its times have one order.
    """

    name: str = about("Name of the clock, such as `CET`, `+05:30` or `UTC`; empty if it was not recorded.")
    offset_s: int = about("Its offset from UTC, s; if its name is not known, times were interpreted as UTC.")


@result
class Mended(Result):
    """A repair, with its count."""

    signal: str = about("The signal, such as `PV`; or `time` for all.")
    count: int = about("Number of samples, or of steps of the clock.")
    first_s: float = about("The first time, s on the recording's clock.")
    done: str = about("The repair, a sentence.")


@result
class Masked(Result):
    """All masked samples of one signal with one value."""

    signal: str = about("The signal, such as `PV`.")
    value: float = about("The recorded value.")
    count: int = about("Number of samples.")
    first_s: float = about("Time of the first of them, s on the recording's clock.")
    kind: str = about("Why it is no measurement.")


@result
class SignalRange(Result):
    """The instrument range of a signal: which values are 0 % and 100 %."""

    low: float = about("The value at 0 %.")
    high: float = about("The value at 100 %.")
    source: str = about("Its source.")
    spans: list[float] = about(
        "The narrowest and the widest plausible span, in the unit of the signal; both that of the range if it is "
        "known."
    )


@result
class Kpi(Result):
    """One key figure of a loop."""

    name: str = about("Its name, such as `OP travel`.")
    value: float | None = about("Its value; None where the data do not give one.")
    unit: str = about("Its unit; empty for a ratio, `PV` for the units of the process value.")
    meaning: str = about("Its meaning, a sentence.")
    note: str | None = about("Why there is no value, or its assumption.")


@result
class Relation(Result):
    """A likely mistake in the columns of a recording, in documents."""

    mismatch: str = about("The mistake, such as `PV and OP look exchanged`.")
    because: str = about("The evidence for it.")
    remedy: str = about("The remedy.")


@result
class NoResponse(Result):
    """A PV that does not respond."""

    silence: str = about(
        "The behaviour of the PV: `PV at its low end`, `PV at its high end`, `PV frozen` or `PV moves without the OP`."
    )
    decides: bool = about("Whether the verdict rests on it.")
    rest: Rest | None = about("The rest of the PV in which the OP travels farthest; None if the PV moves.")
    faults: list[Fault] = about("Possible faults, the likeliest first.")


@result
class Rest(Result):
    """A time in which the PV rests, away from its set point, while the OP travels."""

    from_s: float = about("Its beginning, s on the recording's clock.")
    to_s: float = about("Its end, s on the recording's clock.")
    op_travel: float = about("OP travel in it, percent.")
    error: float = about("Mean of SP less PV in it, in units of the PV.")
    overwhelming: bool = about("Whether it alone names the fault.")


@result
class Fault(Result):
    """A possible fault behind a PV that does not respond, in documents."""

    name: str = about("Its name, such as `line isolated`.")
    told_by: str = about("How to distinguish it from the others.")


@result
class Verdict(Result):
    """Conclusion, basis and reasons."""

    class_: str = about("The conclusion: `sticks`, `does not stick`, `does not respond` or `cannot tell`.")
    grade: str = about(
        "The verdict in one graded word. It splits `cannot tell` into `probably sticks`, `unclear`, `probably fine`, "
        "`too little to matter` and `data cannot answer`, and `does not stick` into `fine` and `no stiction visible`. "
        "The others are `sticks` and `does not respond`."
    )
    probability: float | None = about(
        "The probability of sticking that the recording can show, where a calibrated model gives one."
    )
    basis: str = about("Its basis, such as `evidence in OP and PV`.")
    S_below: Limit | None = about(
        "The detection limit of this recording: an S above it is ruled out with this confidence. It is given for a "
        "cleared valve and if nothing is decided. None if the valve is at fault, if S is a number with an interval, if "
        "no limit is known, and for mistaken columns, unfit data or a recording unlike the training."
    )
    votes: Votes = about("How the families of methods voted.")
    reasons: list[str] = about("Why, in sentences.")
    contradictions: list[str] = about("Evidence against the conclusion, in sentences.")
    alternatives: list[Alternative] = about("Other possible causes, the likeliest first.")
    confirm: TestPlan | None = about(
        "The manual test that would decide, as `stiction test plan` sizes it. None where none is needed, or where "
        "`no_test` gives the reason."
    )
    no_test: str | None = about("Why no test can be made where one is needed.")

    _left_out: ClassVar[Mapping[str, str]] = {
        "override": "the command keeps the conclusions of people",
    }


@result
class Limit(Result):
    """An upper limit of S."""

    value: float = about("Stick band plus dead band, percent of span.")
    confidence: float = about("Of valves that stick by more, the share that would have been detected.")


@result
class Votes(Result):
    """How the families of methods voted."""

    sticks: int = about("Families that find stiction.")
    does_not_stick: int = about("Families that find none.")
    undecided: int = about("Families that apply and are undecided, or divided.")
    abstains: int = about("Families all of whose methods abstain.")


@result
class Alternative(Result):
    """A cause other than the concluded one, and how likely it is."""

    cause: str = about("The cause, such as `aggressive tuning`.")
    likelihood: float = about("Its probability. All of them and that of sticking add up to one.")
    because: str = about("The evidence for it, and how to distinguish it: a sentence.")


@result
class TestPlan(Result):
    """A test of a valve, sized for its loop."""

    name: str = about("Tag of the loop.")
    pv_unit: str | None = about("Unit of the PV, if known.")
    each: int = about("Turns of each size.")
    grow: list[Turn] = about("The turns of the first part, in order. It ends when the PV answers.")
    shrink_by: float = about("Each size of the second part is this multiple of the last one.")
    ends_after: int = about("The second part ends when the PV has not answered this many sizes in a row.")
    answer: float = about("The PV change that counts as an answer, in PV units.")
    rises: bool | None = about("Whether the PV rises when the OP rises; None if the recording does not show it.")
    pv_low: float = about("The controller goes back to automatic below this PV, in its units.")
    pv_high: float = about("The controller goes back to automatic above this PV, in its units.")
    op_low: float = about("The lowest OP, percent.")
    op_high: float = about("The highest OP, percent.")
    record_every_s: float = about("The longest sample interval of OP and PV, s, without compression.")
    total_s: float = about("The longest time in manual, s. The test ends then.")
    expected_s: float = about("The time in manual that is expected, s.")
    summary: str = about("A summary of the test.")
    instructions: list[str] = about("The instructions, in order.")


@result
class Turn(Result):
    """A turn of the OP."""

    op: float = about("The OP, percent of span relative to its value before the test.")
    hold_s: float = about("The longest hold, s.")


@result
class Stiction(Result):
    """The size of a valve's stiction."""

    S: Estimate | None = about("Stick band plus dead band, percent of span.")
    J: Estimate | None = about("Slip jump, percent of span.")
    coverage: float | None = about(
        "The nominal coverage of the intervals, such as 0.9; None where they are not of that kind."
    )
    model: str | None = about("Its source: the valve model, or the measured position.")
    why_not: str | None = about("Why a number is missing.")
    definitions: list[Definition] = about('The competing definitions of "stiction in percent", side by side.')


@result
class Estimate(Result):
    """A number with an interval."""

    value: float = about("The best value.")
    low: float = about("Lower end of its interval.")
    high: float = about("Upper end of its interval.")


@result
class Definition(Result):
    """One of the numbers that are called "stiction in percent"."""

    name: str = about("Its name, such as `apparent stiction`.")
    value: float | None = about("Its value; None where it cannot be measured.")
    unit: str = about("Its unit.")
    meaning: str = about("Its meaning and source.")


@result
class FewSlips(Result):
    """A record that looks stuck, with too few slips to decide."""

    seen: int = about("Slips of the best valve model in all windows, scaled to the whole record.")
    needed: int = about("Slips that a decision needs.")
    step: float = about(
        "Size of OP steps that would make the valve slip, percent of span: half more than the estimated S."
    )
    words: str = about("The same in a sentence.")


@result
class ValveChange(Result):
    """A change of a valve between two of its windows."""

    change: str = about("What changed.")
    time_s: float = about("When: the time of the first window after it, s.")
    interval_s: list[float] = about("The interval of that time, 95 %, s.")
    found_s: float = about("The time of the window with which it was found, s.")


@result
class Window(Result):
    """The result of one window of a segment."""

    from_s: float = about("Time of its first sample, s on the recording's clock.")
    duration_s: float = about("Its duration, s.")
    probability: float = about("The probability that the valve sticks.")
    S: Estimate | None = about("Stick band plus dead band, percent of span, where it could be quantified.")
    J: Estimate | None = about("Slip jump, percent of span, where it could be quantified.")
    S_below: Limit | None = about(
        "The detection limit (95 %): an S above it, percent of span, would have shown in this window."
    )
