"""Results, with the descriptions of their JSON schemas.

Made by `python3 docs/python_api.py` from the schemas of the compiled module, and checked by a test.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from stiction._result import Result, about, result
from stiction.detection import Finding

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
    judged: Judged | None = about("The judged segment, the longest of the grid; None without a segment.")
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
        "Slips of a record that looks stuck but has too few slips to decide; None for other records."
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
    duration_s: float = about("Duration, s.")
    sample_time_s: float = about("Time between samples, s.")
    samples: int = about("Number of samples.")
    bridged: int = about("Number of bridged samples.")
    segments: int = about("Number of segments of the grid.")
    signals: list[str] = about("The recorded signals.")


@result
class PlantTime(Result):
    """The clock for the times of a recording: the plant's clock at the beginning. It stays the same across a change
    to or from summer time, so that the times stay in order.
    """

    name: str = about("Name of the clock, such as `CET`, `+05:30` or `UTC`; empty if it was not recorded.")
    offset_s: int = about("Offset of the clock from UTC, s. If the name is unknown, times were interpreted as UTC.")


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
    first_s: float = about("Time of the first such sample, s on the recording's clock.")
    kind: str = about("Why it is no measurement.")


@result
class SignalRange(Result):
    """The instrument range of a signal: the values at 0 % and 100 %."""

    low: float = about("The value at 0 %.")
    high: float = about("The value at 100 %.")
    source: str = about("Source.")
    spans: list[float] = about(
        "The narrowest and the widest plausible span, in the unit of the signal. Both equal the span of a known range."
    )


@result
class Fitness(Result):
    """Whether a recording is fit for a diagnosis, and why."""

    class_: str = about("The worst class of the measures.", kind='{"fit", "caveats", "unfit"}')
    reasons: list[str] = about("Why it is not fit: the sentences of the bad measures, the worst first.")
    measures: list[Measure] = about("All measures.")


@result
class Measure(Result):
    """One measure of the data."""

    name: str = about("A short name, such as `samples per cycle`.")
    value: float | None = about("Value; None where it could not be measured.")
    unit: str = about("Unit of value and thresholds; empty for a ratio.")
    caveat_at: float | None = about("Threshold of a caveat; whether less or more is worse depends on the measure.")
    unfit_at: float | None = about("Threshold of unfit data.")
    class_: str = about("Class.", kind='{"fit", "caveats", "unfit"}')
    reason: str = about("A sentence with the numbers, for any class.")


@result
class Oscillation(Result):
    """Whether and how a signal oscillates. Times are s from the first sample; in a diagnosis they are on the
    recording's clock.
    """

    found: bool = about("Whether it oscillates; the rule is at `analyse`.")
    basis: str | None = about(
        "The method that found the oscillation.", kind='{"autocorrelation", "spectral peak"} or None'
    )
    period_s: float | None = about("Period of the dominant oscillation, s; None if none was found.")
    amplitude: float | None = about(
        "The swing of the signal with that period, in its units: half of the peak-to-peak value in a period, without "
        "noise, the median over the periods."
    )
    cycles: float | None = about("Number of periods in the signal.")
    regularity: float | None = about(
        "Regularity r of the zero crossings of the autocorrelation (Thornhill, Huang and Zhang, 2003); above 1 is "
        "regular."
    )
    intervals: int = about("Number of intervals between zero crossings for the regularity; 0 without one.")
    decay_ratio: float | None = about(
        "Decay ratio of the autocorrelation (Miao and Seborg, 1999); above 0.5 is oscillatory."
    )
    supervision: Supervision | None = about(
        "Supervision of half waves (Hägglund, 1995) with the detected period as the ultimate period and three standard "
        "deviations of the noise as the amplitude. None if nothing was found or a period has fewer than 8 samples, "
        "because noise then looks like signal."
    )
    peaks: list[Peak] = about("All significant oscillations in the spectrum, by their share of the variance.")
    episodes: list[Episode] = about("Times of the dominant oscillation.")
    reasons: list[str] = about("Reasons for the result, sentences with the numbers.")


@result
class Supervision(Result):
    """The result of the supervision."""

    threshold: float = about(
        "The integral of the absolute error from which a half wave counts, in units of the error times s: `2 a / w_i`."
    )
    disturbances: int = about("Half waves that count as load disturbances.")
    half_waves: int = about("All half waves.")
    counter: float = about("The largest value of the forgetting counter.")
    alarm_s: float | None = about(
        "When the counter first passed the limit, s from the first sample; None if it did not."
    )
    oscillates: bool = about("Whether the loop oscillates: the counter passed its limit.")


@result
class Peak(Result):
    """One of several oscillations of a signal: a significant peak of its spectrum and the band around it."""

    period_s: float = about(
        "Period, s: from the autocorrelation of the band, or from the peak if that has too few crossings."
    )
    amplitude: float = about("Amplitude of a sine with the power of the band, in the signal's units.")
    share: float = about(
        "Share of the band in the signal's variance, without drift: oscillations with fewer than `FEWEST_PERIODS` "
        "periods in the signal are left out."
    )
    regularity: float | None = about(
        "Regularity of the band (`Regularity::index`). A band-pass makes noise look regular, so the index counts only "
        "together with the peak's significance."
    )
    decay_ratio: float | None = about("Decay ratio of the band; noise in such a band has a ratio below 0.5.")
    chance: float = about("The chance that the peak is noise.")
    over_background: float = about("Power of the peak relative to the power of the background.")
    harmonic: int | None = about(
        "Number as a harmonic of a stronger peak; a harmonic is part of that oscillation's shape."
    )
    band: tuple[float, float] = about("The band, cycles per sample.")
    is_oscillation: bool = about(
        "Whether it is a separate oscillation: regular (r > 1), sustained (R > 0.5), with at least a tenth of the "
        "signal's variance, and no harmonic of another. The tenth is our choice. A weaker oscillation has less than a "
        "third of the amplitude of the rest and is not the loop's main problem."
    )


@result
class Episode(Result):
    """A time span with oscillation."""

    from_s: float = about("Beginning, s from the first sample.")
    to_s: float = about("End, s from the first sample.")
    half_waves: int = about("Half waves that belong to the oscillation.")
    amplitude: float = about("Median height of those half waves, in the signal's units.")


@result
class Parameter(Result):
    """A named number."""

    name: str = about("Name, such as `delta tau`.")
    value: float = about("Value.")
    unit: str = about("Unit; empty for a ratio or count.")


@result
class Kpi(Result):
    """One key figure of a loop."""

    name: str = about("Name, such as `OP travel`.")
    value: float | None = about("Value; None where the data do not give one.")
    unit: str = about("Unit; empty for a ratio, `PV` for the units of the process value.")
    meaning: str = about("Meaning, a sentence.")
    note: str | None = about("Why the value is missing, or the assumption behind it.")


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
    decides: bool = about("Whether the verdict is based on the rest.")
    rest: Rest | None = about("The rest of the PV in which the OP travels farthest; None if the PV moves.")
    faults: list[Fault] = about("Possible faults, the likeliest first.")


@result
class Rest(Result):
    """A time in which the PV rests, away from its set point, while the OP travels."""

    from_s: float = about("Beginning, s on the recording's clock.")
    to_s: float = about("End, s on the recording's clock.")
    op_travel: float = about("OP travel during the rest, percent.")
    error: float = about("Mean of SP less PV during the rest, in units of the PV.")
    overwhelming: bool = about("Whether it alone is enough to name the fault.")


@result
class Fault(Result):
    """A possible fault that explains why the PV does not respond, in documents."""

    name: str = about("Name, such as `line isolated`.")
    told_by: str = about("How to distinguish this fault from the others.")


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
        "The probability of stiction that the recording can show, where a calibrated model gives one."
    )
    basis: str = about("Basis, such as `evidence in OP and PV`.")
    S_below: Limit | None = about(
        "The detection limit of this recording: an S above it is ruled out with this confidence. It is given for a "
        "cleared valve and if nothing is decided. None if the valve is at fault, S has an interval or no limit is "
        "known. Also None for mistaken columns, unfit data or a recording unlike the training."
    )
    votes: Votes = about("How the families of methods voted.")
    reasons: list[str] = about("Why, in sentences.")
    contradictions: list[str] = about("Evidence against the conclusion, in sentences.")
    alternatives: list[Alternative] = about("Other possible causes, the likeliest first.")
    confirm: TestPlan | None = about(
        "The manual test that would decide, as `stiction test plan` sizes it. None where no test is needed, or where "
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
    confidence: float = about("Share of the valves with a larger S that would have been detected.")


@result
class Votes(Result):
    """How the families of methods voted."""

    sticks: int = about("Families that find stiction.")
    does_not_stick: int = about("Families that find none.")
    undecided: int = about("Families that apply and are undecided, or divided.")
    abstains: int = about("Families all of whose methods abstain.")


@result
class Alternative(Result):
    """A cause other than the conclusion, and its likelihood."""

    cause: str = about("The cause, such as `aggressive tuning`.")
    likelihood: float = about("Probability. The likelihoods of sticking and of all other causes add up to one.")
    because: str = about("The evidence for it, and how to distinguish it: a sentence.")


@result
class TestPlan(Result):
    """A test of a valve, sized for its loop."""

    name: str = about("Tag of the loop.")
    pv_unit: str | None = about("Unit of the PV, if known.")
    each: int = about("Turns of each size.")
    grow: list[Turn] = about("The turns of the first part, in order. This part ends when the PV answers.")
    shrink_by: float = about("Each size of the second part is this multiple of the previous one.")
    ends_after: int = about("The second part ends when this number of consecutive sizes has had no response.")
    answer: float = about("The PV change that counts as an answer, in PV units.")
    rises: bool | None = about("Whether the PV rises when the OP rises; None if the recording does not show it.")
    pv_low: float = about("The controller goes back to automatic below this PV, in its units.")
    pv_high: float = about("The controller goes back to automatic above this PV, in its units.")
    op_low: float = about("The lowest OP, percent.")
    op_high: float = about("The highest OP, percent.")
    record_every_s: float = about("The longest sample interval of OP and PV, s, without compression.")
    total_s: float = about("The longest time in manual, s. The test ends after this time.")
    expected_s: float = about("The expected time in manual, s.")
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
        "The nominal coverage of the intervals, such as 0.9; None for intervals without a nominal coverage."
    )
    model: str | None = about("The source of the numbers: the valve model, or the measured position.")
    why_not: str | None = about("Why a number is missing.")
    definitions: list[Definition] = about('The competing definitions of "stiction in percent", side by side.')


@result
class Estimate(Result):
    """A number with an interval."""

    value: float = about("The best value.")
    low: float = about("Lower end of the interval.")
    high: float = about("Upper end of the interval.")


@result
class Definition(Result):
    """One of the numbers that are called "stiction in percent"."""

    name: str = about("Name, such as `apparent stiction`.")
    value: float | None = about("Value; None where it cannot be measured.")
    unit: str = about("Unit.")
    meaning: str = about("Meaning and source.")


@result
class FewSlips(Result):
    """A record that looks stuck, with too few slips to decide."""

    seen: int = about("Slips of the best valve model in all windows, scaled to the whole record.")
    needed: int = about("Slips that a decision needs.")
    step: float = about(
        "Size of OP steps that would make the valve slip, percent of span: half more than the estimated S."
    )
    words: str = about("These numbers in a sentence.")


@result
class ValveChange(Result):
    """A change of a valve between two of its windows."""

    change: str = about("What changed.")
    time_s: float = about("Time of the change: the first window after it, s.")
    interval_s: list[float] = about("The 95 % interval of that time, s.")
    found_s: float = about("The time of the window with which it was found, s.")


@result
class Window(Result):
    """The result of one window of a segment."""

    from_s: float = about("Time of its first sample, s on the recording's clock.")
    duration_s: float = about("Duration, s.")
    probability: float = about("The probability that the valve sticks.")
    S: Estimate | None = about("Stick band plus dead band, percent of span, where it could be quantified.")
    J: Estimate | None = about("Slip jump, percent of span, where it could be quantified.")
    S_below: Limit | None = about(
        "The detection limit (95 %): an S above it, percent of span, would have been visible in this window."
    )


@result
class Observation(Result):
    """The result of one recording or window of a valve."""

    time_s: float = about("Time, s on a clock that all observations share.")
    class_: str = about("The conclusion.")
    probability: float | None = about("The probability that the valve sticks, where there is one.", default=None)
    S: Estimate | None = about("Stick band plus dead band, percent of span, where it was quantified.", default=None)
    J: Estimate | None = about("Slip jump, percent of span, where it was quantified.", default=None)
    weight: float = about(
        "Weight among observations that decide by majority or have no pool, such as the number of cycles; 1 if all "
        "observations have the same weight. An observation of weight 0 does not count.", default=1.0
    )
    windows: float = about(
        "Number of windows of a long recording in it, with overlaps counted once; 1 for a short recording.", default=1.0
    )
    grade: str | None = about(
        "The verdict in one graded word; None for the word that follows from conclusion and probability.", default=None
    )
    pool: str | None = about(
        "The combined evidence of these windows. It adds to the evidence of other observations as if all were one "
        "recording. It is None without a PV, or if the probability is not from the windows.", default=None
    )


@result
class History(Result):
    """The combined observations of one valve in its present state."""

    class_: str = about(
        "The conclusion by the combined probability; without one, the conclusion with more than half of the weight of "
        "all decisions."
    )
    grade: str = about("The conclusion in one graded word, as in `Verdict`.")
    probability: float | None = about("The combined probability that the valve sticks; None if no observation has one.")
    observations: int = about("Number of observations since the last change of the valve.")
    decided: int = about("Number of these that decided, or have a probability.")
    changes: list[ValveChange] = about(
        "The changes of the valve. Observations before the valve last began or ceased to stick do not count."
    )
    drift: Drift | None = about("Whether S drifts; None with too few observations of S.")
    trend: str = about("The drift in a sentence.")

    _documented_as: ClassVar[Mapping[str, str]] = {
        "observations": "windows",
    }


@result
class Drift(Result):
    """The drift of S."""

    per_day: float = about("Growth of S as a share of itself, 1/day: 0.01 is 1 % a day.")
    low: float = about("Lower end of its 95 % interval.")
    high: float = about("Upper end of its 95 % interval.")
    p_value: float = about("Probability of such a slope without a drift, two-sided.")
    robust_per_day: float = about("The growth by the median of the slopes of all pairs, 1/day.")
    robust_p_value: float = about("p-value of Mann and Kendall's test.")
    significant: bool = about("Whether both tests and both slopes show that S drifts.")


@result
class RepairEffect(Result):
    """Before and after a repair."""

    time_s: float = about("Time of the repair, s on the clock of the observations.")
    outcome: str = about("The outcome.", kind='{"worked", "helped", "no change", "worse", "cannot tell"}')
    words: str = about("The outcome in a sentence.")
    before: int = about("Number of observations before the repair.")
    after: int = about("Number of observations after the repair.")
    probability: Contrast | None = about(
        "The probability that the valve sticks, by the mean log-odds of a side; None with too few observations."
    )
    S: Contrast | None = about("S in percent of span, by the geometric mean of a side; None with too few observations.")


@result
class Contrast(Result):
    """A quantity before and after."""

    before_count: int = about("Number of observations of the quantity before the repair.")
    after_count: int = about("Number of observations of the quantity after the repair.")
    before: float = about("Typical value before.")
    after: float = about("Typical value after.")
    p_value: float = about("Probability of as large a difference by chance, two-sided.")
    delta: float = about("Cliff's delta: from -1 (all fell) to 1 (all rose).")
    significant: bool = about("Whether the difference is significant as one of two tests.")


@result
class OperatingPoint(Result):
    """The operating point."""

    op: float = about("Mean of the OP, percent.")
    pv: float = about("Mean of the PV, in its units.")
    op_drift_per_hour: float = about("Slope of the OP, percent per hour: drift of the load.")


@result
class FittedController(Result):
    """A controller identified from its output."""

    structure: str = about("Structure.", kind='{"P", "PI", "PID"}')
    kc: Estimate = about("Gain, percent of OP per unit of PV; negative for a direct-acting controller.")
    ti: Estimate | None = about("Integral time, s; None without integral action.")
    td: Estimate | None = about("Derivative time, s; None without derivative action.")
    filter: float | None = about("Time constant of the derivative's filter, s.")
    set_point_weight: float | None = about(
        "Weight of the set point in the proportional part, where the set point moves."
    )
    set_point: Estimate | None = about("The constant set point, in units of the PV, where none is recorded.")
    gap: float = about("Half width of the gap in which the error is ignored, in units of the PV; 0 for none.")
    execution: float | None = about("Time between executions, s; None if it is shorter than the record can show.")
    delay_samples: int = about("Samples from a PV to the response of the OP: 0 or 1.")
    low: float | None = about("The lower limit of the OP, percent, where it was reached.")
    high: float | None = about("The upper limit of the OP, percent, where it was reached.")
    rate_limit: float | None = about("The fastest movement of the OP, percent per second, if it was reached often.")
    op_quantum: float = about("Resolution of the recorded OP, percent; 0 if none is visible.")
    explained: float = about("Share of the OP's innovations that it explains.")
    otherwise: float = about(
        "Share of the samples at which something else moved the OP: an operator, tracking, an upset of the record."
    )


@result
class FittedProcess(Result):
    """A process identified from PV and OP or valve position."""

    kind: str = about("Behaviour under a constant input.", kind='{"self-regulating", "integrating"}')
    gain: Estimate | None = about(
        "Gain, units of PV per percent; None for an integrating one, and if it cannot be separated from the lag."
    )
    tau: Estimate | None = about("Time constant, s; None in the same cases.")
    slope: Estimate = about(
        "Initial slope of the PV after a step of one percent, units of PV per second. This is gain over lag, which may "
        "be known even if gain and lag are not."
    )
    delay: Estimate = about("Dead time with all small lags, s.")
    explained: float = about("Share of the PV's innovations that the input explains.")
    jointly: str | None = about("What the data cannot identify, in a sentence; None if everything is identified.")
    disturbance_sd: float = about("Standard deviation of the disturbance of the PV, in its units.")
    innovation_sd: float = about("Standard deviation of its innovations from sample to sample.")


@result
class FittedValve(Result):
    """The valve of a recording."""

    model: str | None = about("Model; None if all possible valves follow their OP.")
    S: Estimate = about("Stick band plus dead band if it sticks, percent of span.")
    J: Estimate = about("Slip jump if it sticks, percent of span.")
    follows: float = about("Weight of the valves that follow their OP among all possible ones, from 0 to 1.")
    from_: str = about("Source of S and J.")


@result
class FittedCycle(Result):
    """The recorded swing, the limit cycle of the fitted loop, and the swing with a valve that follows."""

    recorded: RecordedSwing | None = about("The recorded oscillation; None if nothing oscillates.")
    predicted: PredictedSwing | None = about("The predicted oscillation; None if hardly any drawn loop cycles.")
    cycling: float = about("Share of the drawn loops that have a limit cycle.")
    pv_swing_left: Estimate | None = about(
        "Share of the PV's oscillation, the root of its power near the period, that would remain if the valve followed "
        "its OP; None if nothing oscillates or it could not be computed."
    )
    explained: bool | None = about(
        "Whether the valve explains the swing: the fitted loop cycles as the recording does, or most of the swing "
        "would vanish if the valve followed its OP (`MOST_LEFT`). None if nothing oscillates."
    )
    sentence: str = about("The same in words.")


@result
class RecordedSwing(Result):
    """An oscillation of a loop."""

    period_s: float = about("Period, s.")
    op: float = about("Swing of the OP, as `amplitude` of an `Oscillation`, percent of span.")
    pv: float = about("Swing of the PV about its set point, as `amplitude` of an `Oscillation`, in PV units.")


@result
class PredictedSwing(Result):
    """The behaviour of the fitted loop without disturbances."""

    period_s: Estimate = about("Period of its limit cycle, s.")
    op: Estimate = about("Half of the OP's peak-to-peak value, percent of span.")
    pv: Estimate = about("Half of the PV's peak-to-peak value, in its units.")


@result
class RankedProspects(Result):
    """Possible actions on a recorded loop, the best first."""

    actions: list[Prospect] = about("The actions, by the upper end of the ratio of the control error, then by effort.")
    loops: int = about("Number of simulated loops.")
    advice: list[str] = about("The advice, in sentences.")


@result
class Prospect(Result):
    """The effect of an action. Intervals are the 5 and 95 % points of the drawn loops."""

    action: str = about(
        "The action: `as it is`, `valve repaired`, `retuned`, `repaired and retuned`, `positioner`, or the name of a "
        "compensator."
    )
    pv_swing: Estimate = about("Swing of the PV about its set point, as `amplitude` of an `Oscillation`, in PV units.")
    pv_swing_ratio: Estimate = about(
        "Ratio of the PV swing to the PV swing of the present loop, for each drawn loop; 20 for 20 or more."
    )
    error: Estimate = about("Mean absolute control error, in units of the PV.")
    error_ratio: Estimate = about(
        "Ratio of the control error to the control error of the present loop, for each drawn loop; 20 for 20 or more."
    )
    travel: Estimate = about("Valve travel, percent of span per hour.")
    settling_s: Estimate | None = about("Time to settle after a load step, s; None if half of the loops do not settle.")
    sure: float = about(
        "Probability that the PV swing falls by more than 20 %; from 0.95 on the benefit is called certain, above 0.5 "
        "probable."
    )
    tuning: Proposal | None = about("The tuning of the action, if it has one.")


@result
class Proposal(Result):
    """A proposed tuning."""

    kc: float = about("Gain, percent per unit of PV.")
    ti: float = about("Integral time, s.")
    ms: Estimate = about("Largest sensitivity (Ms) with this tuning, over all drawn loops; 2 or less is robust.")
    rule: str = about("Rule.")

    _documented_as: ClassVar[Mapping[str, str]] = {
        "ms": "Ms",
    }


@result
class TestReading(Result):
    """The result of a valve test."""

    class_: str = about(
        "`sticks`, `does not stick`, `does not respond` or `cannot tell`, from the test and the operation before it."
    )
    probability: float = about("Probability that the valve sticks, from both.")
    by_test: float = about("Probability that the valve sticks, from the test alone.")
    by_operation: float | None = about(
        "Probability that the valve sticks, from the recording before the test; None if it gives none."
    )
    dead_band_elsewhere: float = about(
        "Probability of a dead band downstream of the valve, in the process, a linkage or the transmitter."
    )
    S: Estimate | None = about(
        "Stick band plus dead band, percent of span, with its 90 % interval, if the valve sticks."
    )
    J: Estimate | None = about("Slip jump, percent of span, with its 90 % interval, if the valve sticks.")
    S_below: float | None = about("S is below this with 95 % confidence, percent; None if the test gives no limit.")
    response_s: float | None = about(
        "Sum of dead time and lags between OP and PV, s; None if no turn was answered, or the test was shorter."
    )
    known_by: str = about("The source of the manual settings: `sheet`, `mode` or `output`.")
    from_s: float = about("Start of the test, s on the recording's clock.")
    to_s: float = about("End of the test, s on the recording's clock.")
    stops: int = about("Number of times that the controller took over during the test.")
    by_position: bool = about("Whether the responses are read from the recorded valve position instead of the PV.")
    position: PositionReading | None = about("Results from the valve position; None if it is not recorded.")
    steps: list[Step] = about("The turns, in order.")
    reasons: list[str] = about("The reasons, in sentences.")
    advice: str | None = about("How to repeat the test, if it is inconclusive.")
    plan: PlanComparison | None = about("The comparison with the plan, if one was given.")


@result
class PositionReading(Result):
    """Results from the stem position, by the definitions of ANSI/ISA-75.25.01 (recalled)."""

    dead_band: Between | None = about(
        "The OP change after a reversal before the stem moves, percent; None without a reversal."
    )
    resolution: Between | None = about(
        "The OP change in one direction before the stem moves again, percent; None if each turn is a reversal."
    )
    dead_time_s: float | None = about(
        "Median time until the stem begins to move, s; None if no turn moved it by 2 % or more."
    )
    t63_s: float | None = about("Median time until the stem has covered 63.2 % of its travel, s.")
    t86_s: float | None = about("Median time until the stem has covered 86.5 % of its travel, s.")
    timed: int = about("Number of turns in these medians.")


@result
class Between(Result):
    """The OP change that moves the stem, percent, as an interval between two turns."""

    above: float = about("The largest change that did not move the stem; 0 if every change moved it.")
    up_to: float | None = about("The smallest change that moved the stem; None if none did.")


@result
class Step(Result):
    """A turn of the OP and its answer."""

    at_s: float = about("Time of the OP setting, s on the recording's clock.")
    op: float = about("The OP after the turn, percent.")
    travel: float | None = about(
        "The change of the OP, percent; None for the first turn of a time in manual, because the stem position before "
        "it is unknown, and if the OP did not change."
    )
    answer: float | None = about(
        "The PV change until the next turn, or until the process has responded if the next turn follows sooner, in PV "
        "units."
    )
    error: float | None = about("Standard deviation of the answer.")
    answered: bool = about("Whether the PV moved with the turn by more than 2.5 standard deviations.")


@result
class PlanComparison(Result):
    """A test compared with its plan."""

    sizes: list[SizeComparison] = about("The sizes, in the order of the test or the plan.")
    turns_planned: int = about("Planned turns of these sizes.")
    turns: int = about("Turns in the test.")
    cut_short: int = about("Turns of part 1 that ended before the planned hold, although the PV had not answered.")
    held_longer: int = about("Turns of part 1 that were held longer than planned.")
    pv_beyond_s: float = about("Time of the PV outside the limits of the plan during the test, s.")
    pv_low: float = about("The lowest PV of the test, in PV units.")
    pv_high: float = about("The highest PV of the test, in PV units.")
    remarks: list[str] = about("Deviations from the plan, in sentences. One sentence if the test has no deviations.")


@result
class SizeComparison(Result):
    """A size of the plan and its turns in the test."""

    part: int = about("The part of the test: 1 with growing sizes, 2 with shrinking sizes.")
    planned: float | None = about("The planned size, percent from one turn to the next; None if it is not in the plan.")
    made: float | None = about("The actual size, percent; None if it was left out.")
    turns: int = about("Number of turns of this size.")
    answered: int = about("Number of these turns that the PV answered.")
    hold_planned_s: float | None = about(
        "The longest planned hold, s; None in part 2, where it depends on the answers."
    )
    hold_s: float | None = about("The longest actual hold, s; None if the size was left out.")


@result
class Difference(Result):
    """S after minus S before."""

    value: float | None = about("The best value, percent of span; None if a test gives only a limit of S.")
    low: float = about("Lower end of its 90 % interval, percent of span.")
    high: float = about("Upper end.")


@result
class SignaturePlan(Result):
    """The planned signature of a valve."""

    name: str = about("Tag of the loop.")
    from_op: float = about("The OP at the start, percent.")
    ramps: list[Ramp] = about("The ramps, in order.")
    record_every_s: float = about("The longest sample interval of OP and VP, s, without compression.")
    total_s: float = about("Duration of all ramps and holds, s.")
    summary: str = about("A summary of the test.")
    instructions: list[str] = about("The instructions, in order.")


@result
class Ramp(Result):
    """A ramp of the plan."""

    to_op: float = about("The OP at its end, percent.")
    duration_s: float = about("Duration, s.")
    hold_s: float = about("The hold at its end, s.")


@result
class SignatureReading(Result):
    """The result of a signature."""

    class_: str = about("`sticks`, `does not stick`, `does not respond` or `cannot tell`.")
    S: Estimate | None = about(
        "Stick band plus dead band, percent of span, with its 90 % interval, outside the part of the stroke that "
        "binds."
    )
    J: Estimate | None = about("Slip jump, percent of span, with its 90 % interval; None if S is.")
    op: list[float] = about("The OP range of the ramps, percent.")
    vp: list[float] = about("The range of the stem, percent; of the PV as a position if no position was recorded.")
    offset: float = about("Mean of the simulated stem minus VP, percent: the calibration error.")
    places: list[Place] = about("The parts of the stroke, from the lowest.")
    binds: list[float] | None = about(
        "The part of the stroke where the stem binds: its S there is clearly larger than elsewhere."
    )
    ramps: int = about("Number of ramps.")
    from_s: float = about("Start of the ramps, s on the recording's clock.")
    to_s: float = about("End of the ramps, s on the recording's clock.")
    reasons: list[str] = about("The reasons, in sentences.")


@result
class Place(Result):
    """A part of the stroke."""

    from_: float = about("The stem position at its lower end, percent.")
    to: float = about("The stem position at its upper end, percent.")
    S: Estimate = about("Stick band plus dead band there, percent of span, with its 90 % interval.")


@result
class Checked(Result):
    """The files and loops of a plant, and problems in them."""

    plant: str = about("Name of the plant.")
    files: int = about("Files named in the plant's file.")
    loops: list[LoopThere] = about("Loops in these files.")
    problems: list[Problem] = about("Problems.")
    unknown: list[Unknown] = about("These problems, loops without a PV, and tags without a partner.")
    no_recordings: list[str] = about("Files that are no recordings because they have no OP, a sentence each.")


@result
class LoopThere(Result):
    """A loop in the data."""

    loop: str = about("Tag.")
    days: int = about("Days with samples.")
    first_day: str | None = about("The first of these days.")
    last_day: str | None = about("The last of these days.")
    in_plant_file: bool = about("Whether it is in the plant's file.")
    tags: list[str] = about('Tags of the signals in the last file of the loop, such as `op = "FIC101.OP"`.')
    op_range: list[float] | None = about("The values of OP that are 0 % and 100 %.", kind='list of two floats or None')
    modes: list[str] = about("Modes: `auto`, `cascade`, `manual`, `other`. Empty if its mode is not recorded.")
    notes: list[str] = about("Assumptions, and points to confirm.")


@result
class Problem(Result):
    """A file or loop that could not be read."""

    file: str | None = about("The file; none if the problem concerns all files.")
    loop: str | None = about("The loop; none if the problem concerns the whole file.")
    message: str = about("Fault and remedy.")


@result
class Unknown(Result):
    """Something that could not be read or judged, with the reason."""

    kind: str = about(
        "Kind: `file not read`, `loop not read`, `loop without a PV`, `tag without a partner` or `window not judged`."
    )
    name: str = about("File, loop or tag.")
    count: int = about("Number of windows of a loop that were not judged; 1 for all other kinds.")
    reason: str = about("The reason, with a remedy.")


@result
class Status(Result):
    """The windows judged so far."""

    plant: str = about("Name of the plant.")
    loops: int = about("Loops with a window.")
    days: int = about("Days of the plant with a window.")
    first_day: str | None = about("The first of these days.")
    last_day: str | None = about("The last of these days.")
    windows: int = about("Windows that count.")
    errors: int = about("Of these, windows that could not be judged.")
    time_limited: int = about("Of these, windows that reached the time limit of their scan.")
    grades: list[Graded] = about("Windows by grade, the worst first.")
    runs: int = about("Runs.")
    cut_short: int = about("Incomplete runs since the last complete scan of all loops and days.")
    damaged: list[str] = about("Damaged files of the store, a sentence each.")
    changes: Changes = about("Differences of the data files from the last scan.")
    unknown: list[Unknown] = about(
        "What the last scan did not read of the data, and all windows that could not be judged."
    )


@result
class Graded(Result):
    """The number of windows with a grade."""

    grade: str = about("The grade.")
    windows: int = about("Windows.")


@result
class Changes(Result):
    """Data files that differ from the last scan."""

    new: list[str] = about("Files that no scan has read.")
    changed: list[str] = about("Files with different content, or with a different size or date before they are read.")
    missing: list[str] = about("Files that no longer exist. The verdicts on their windows stay.")


@result
class Scanned(Result):
    """The result of a scan."""

    plant: str = about("Name of the plant.")
    run: str | None = about("Name of the run; none if nothing was new.")
    engine_version: str = about("Version of the program.")
    model_version: str = about("The training of the verdict.")
    files: int = about("Files that were examined.")
    loops: int = about("Loops in these files.")
    windows: int = about("Windows that were judged in this run.")
    errors: int = about("Of these, windows that could not be judged.")
    parts: int = about("Number of parts of the store that keep their rows.")
    problems: list[Problem] = about("Files and loops that could not be read.")
    unknown: list[Unknown] = about(
        "These problems, loops without a PV, tags without a partner, and the windows of this run that were not judged."
    )
    no_recordings: list[str] = about("Files that are no recordings because they have no OP, a sentence each.")
    damaged: list[str] = about("Files of earlier runs that were found damaged, a sentence each.")
    changes: Changes = about("Differences of the data files from the previous scan.")


@result
class Group(Result):
    """Loops that swing together, and the candidates for the source."""

    id: int = about("Number, from one.")
    period_s: float = about("Period of the swing, s.")
    members: list[Member] = about("The loops: candidates for the source in their order, then the others by coherence.")
    source: str = about("Whether one of them may be the source.", kind='{"candidates", "not-recorded"}')
    reasons: list[str] = about("Evidence for the group, sentences.")


@result
class Member(Result):
    """A loop of a group."""

    loop: str = about("Tag.")
    coherence: float = about(
        "The share of its swing at the period that it has in common with the group: squared coherence, 0 to 1."
    )
    candidate_rank: int | None = about(
        "Rank among the candidates for the source, from 1; none if the loop is no candidate."
    )
    reasons: list[str] = about("Evidence for and against it as the source, sentences.")


@result
class Compensator(Result):
    """A published or practised compensator: the description of a `Method`."""

    name: str = about("Name in commands.")
    summary: str = about("Principle, in one line.")
    citation: str = about("Source.")


@result
class FrictionLaw(Result):
    """The description of a friction law."""

    name: str = about("Name, as a user writes it.")
    summary: str = about("Principle, in one line.")
    source: str = about("Source, cited from memory and not verified unless stated otherwise.")
    parameters: list[str] = about(
        "Names of its parameters, with their units, in the order `FrictionLaw::from_name` takes them."
    )


@result
class FmuModel(Result):
    """A model that can be exported."""

    kind: str = about("`valve`, `stem` or `loop`.")
    name: str = about("The law of the valve, or the friction law or parameter set of the stem.")
    summary: str = about("Description, in one line.")

    _documented_as: ClassVar[Mapping[str, str]] = {
        "kind": "model",
        "name": "law",
    }


@result
class FmuVariable(Result):
    """A variable of an FMU, in documents."""

    name: str = about("Name.")
    role: str = about(
        "Purpose: `time`, `input`, `output`, `parameter`, `tunable` (a parameter that may be changed while the "
        "simulation runs) or `local`."
    )
    start: float | bool | None = about(
        "Value at the start; None if it is computed.", kind='float or int or bool or None'
    )
    unit: str = about("Unit; empty if there is none.")
    description: str = about("Description, in one line.")


@result
class Tuning(Result):
    """Gain and times of a controller."""

    kc: float = about("Gain, percent per PV unit.")
    ti: float | None = about("Integral time, s; None without integral action.")
    td: float = about("Derivative time, s; 0 without derivative action.")


@result
class ValveModel(Result):
    """A published valve model: the description of a `Model`, in words and properties."""

    name: str = about("Name in commands.")
    aliases: list[str] = about("Other names.")
    summary: str = about("Principle, in one line.")
    citation: str = about("Source.")
    uses_s: bool = about("Whether it uses `S`.")
    uses_j: bool = about("Whether it uses `J`.")
    uses_k: bool = about("Whether it uses the overshoot `K` of a slip.")
    uses_rest_tolerance: bool = about("Whether it uses a rest tolerance.")
