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
    "Mended",
    "NoResponse",
    "PlantTime",
    "Relation",
    "Rest",
    "Stiction",
    "TestPlan",
    "Turn",
    "Verdict",
    "Votes",
    "Window",
]


@result
class Found(Result):
    """The diagnosis of one loop."""

    name: str = about("Tag of the loop.")
    loop_type: str = about("What it controls.")
    verdict: Verdict = about("The conclusion.")
    stiction: Stiction = about("How much the valve sticks.")
    oscillation: Oscillation | None = about(
        "The oscillation that speaks for the loop, with times on the recording's clock; None without a segment to "
        "judge."
    )
    judged: Judged | None = about("The segment that was judged, the longest of the grid; None if there is none.")
    plant_time: PlantTime = about("The clock of the plant, in which its times are shown.")
    repairs: list[Mended] = about("What had to be mended in the data.")
    fitness: Fitness = about("Whether the data can answer.")
    findings: dict[str, Finding] = about("What each method that was asked says, in the order of the registry.")
    kpis: dict[str, Kpi] = about("Key figures of the loop.")
    relation: Relation | None = about(
        "The likely mistake in the columns; None where OP and PV belong together, as far as can be told."
    )
    no_response: NoResponse | None = about(
        "What the PV does that does not respond; None where it responds, as far as can be told."
    )
    few_slips: FewSlips | None = about(
        "Slips that a record lacks which looks stuck; None where it does not, or has enough."
    )
    windows: list[Window] = about("The windows of the judged segment that were weighed one by one, in order of time.")
    notes: list[str] = about("What the reader of the file, or a step on the way, wants the user to know.")

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
    bridged: int = about("How many of them were bridged.")
    segments: int = about("Out of how many segments it was taken.")
    signals: list[str] = about("The signals it has.")


@result
class PlantTime(Result):
    """How the instants of a recording are written: by the clock of the plant, as it went at the beginning. A
    recording that lasts beyond a change to or from summer time keeps it, so that its times have one order.
    """

    name: str = about("What the clock is called, such as `CET`, `+05:30` or `UTC`; empty where it was not recorded.")
    offset_s: int = about(
        "How far it goes before UTC, s; where its name is not known, times were taken as if it were UTC."
    )


@result
class Mended(Result):
    """Something that had to be mended, and how often."""

    signal: str = about("The signal, such as `PV`; or `time` for all.")
    count: int = about("How many samples, or steps of the clock.")
    first_s: float = about("The first place, s on the recording's clock.")
    done: str = about("What was done, a sentence.")


@result
class Kpi(Result):
    """One number about a loop."""

    name: str = about("Its name, such as `OP travel`.")
    value: float | None = about("Its value; None where the data do not give one.")
    unit: str = about("Its unit; empty for a ratio, `PV` for the units of the process value.")
    meaning: str = about("What it is, a sentence.")
    note: str | None = about("Why there is no value, or what it assumes.")


@result
class Relation(Result):
    """A likely mistake in the columns of a recording, as documents tell it."""

    mismatch: str = about("The mistake, such as `PV and OP look exchanged`.")
    because: str = about("What the data show of it.")
    remedy: str = about("What to do about it.")


@result
class NoResponse(Result):
    """A PV that does not respond."""

    silence: str = about(
        "What the PV does: `PV at its low end`, `PV at its high end`, `PV frozen` or `PV moves without the OP`."
    )
    decides: bool = about("Whether the verdict rests on it.")
    rest: Rest | None = about("The rest of the PV in which the OP travels farthest; None if it moves on.")
    faults: list[Fault] = about("What it may be, the likeliest first.")


@result
class Rest(Result):
    """A time in which the PV rests, away from its set point, while the OP travels."""

    from_s: float = about("Its beginning, s on the recording's clock.")
    to_s: float = about("Its end, s on the recording's clock.")
    op_travel: float = about("How far the OP travels in it, percent.")
    error: float = about("Mean of SP less PV in it, in units of the PV.")
    overwhelming: bool = about("Whether that alone names the fault.")


@result
class Fault(Result):
    """Why a PV may not respond, as documents tell it."""

    name: str = about("Its name, such as `line isolated`.")
    told_by: str = about("How to tell it from the others.")


@result
class Verdict(Result):
    """What is concluded, on what, and why."""

    class_: str = about("The conclusion: `sticks`, `does not stick`, `does not respond` or `cannot tell`.")
    grade: str = about(
        "The verdict in one graded word. It splits `cannot tell` into `probably sticks`, `unclear`, `probably fine` "
        "and `data cannot answer`. The others are `sticks`, `fine` and `does not respond`."
    )
    probability: float | None = about(
        "The probability that the valve sticks, where a calibrated model gives one. A majority has none."
    )
    basis: str = about("What it rests on, such as `evidence in OP and PV`.")
    S_below: Limit | None = about(
        "What this very recording would have shown: an S above this is ruled out with this confidence. Told where the "
        "valve is cleared, and where nothing is decided; None where the valve is at fault, where S is a number with an "
        "interval, where what is wrong lies deeper (mistaken columns, unfit data, a recording unlike the training), or "
        "where no such number is known."
    )
    votes: Votes = about("How the families of published methods voted.")
    reasons: list[str] = about("Why, in sentences.")
    contradictions: list[str] = about("Evidence that speaks against the conclusion, in sentences.")
    alternatives: list[Alternative] = about("What else it could be, the likeliest first.")
    confirm: TestPlan | None = about(
        "The manual test that would settle it, as `stiction test plan` sizes it. None where none is needed, or where "
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
    confidence: float = about("Of valves that stick by more, the share that would have been seen.")


@result
class Votes(Result):
    """How the families of methods voted."""

    sticks: int = about("Families that say the valve sticks.")
    does_not_stick: int = about("Families that say it does not.")
    undecided: int = about("Families that apply and are undecided, or divided.")
    abstains: int = about("Families all of whose methods abstain.")


@result
class Alternative(Result):
    """A cause other than the concluded one, and how likely it is."""

    cause: str = about("The cause, such as `aggressive tuning`.")
    likelihood: float = about("Its probability; together with that of sticking they add up to one.")
    because: str = about("What the data show of it, and how to tell it apart: a sentence.")


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
    total_s: float = about("The longest duration of the first part, s.")
    summary: str = about("A summary of the test.")
    instructions: list[str] = about("The instructions, in order.")


@result
class Turn(Result):
    """A turn of the OP."""

    op: float = about("The OP, percent of span relative to its value before the test.")
    hold_s: float = about("The longest hold, s.")


@result
class Stiction(Result):
    """How much a valve sticks."""

    S: Estimate | None = about("Stick band plus dead band, percent of span.")
    J: Estimate | None = about("Slip jump, percent of span.")
    coverage: float | None = about(
        "The nominal coverage of the intervals, such as 0.9; None where they are not of that kind."
    )
    model: str | None = about("What it was found with: the valve model, or the measured position.")
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
    meaning: str = about("What it is, and by whom.")


@result
class FewSlips(Result):
    """A record that looks stuck, with too few slips to decide."""

    seen: int = about("Slips that the best valve model sees in all windows, scaled to all of the record.")
    needed: int = about("Slips that a decision takes.")
    record_for_s: float | None = about(
        "For how much longer to record, s, if the valve goes on slipping as often; None if it never slipped."
    )
    step: float = about(
        "How large steps of the OP would make it slip, percent of span: half more than the S that is estimated."
    )
    words: str = about("The same, a sentence.")


@result
class Window(Result):
    """What one window of a segment says."""

    from_s: float = about("Time of its first sample, s on the recording's clock.")
    duration_s: float = about("Its duration, s.")
    probability: float = about("The probability that the valve sticks.")
    S: Estimate | None = about("Stick band plus dead band, percent of span, where it could be quantified.")
    J: Estimate | None = about("Slip jump, percent of span, where it could be quantified.")
    S_below: Limit | None = about(
        "Had the valve stuck by more, percent of span, this window would have shown it, with 95 %."
    )
