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
    judged: Judged | None = about("The judged segment, which is the longest segment; None without a segment.")
    plant_time: PlantTime = about("The clock of the plant, in which all times are shown.")
    repairs: list[Mended] = about("Repairs of the data.")
    masked: list[Masked] = about("Values that are no measurements and count as missing, in the whole recording.")
    op_range: SignalRange | None = about(
        "The values of the OP at 0 % and 100 %, with all plausible spans; None if the OP is in percent."
    )
    fitness: Fitness = about("Fitness of the data.")
    findings: dict[str, Finding] = about("The result of each method that was run.")
    kpis: dict[str, Kpi] = about("Key figures of the loop.")
    relation: Relation | None = about("The likely mistake in the columns; None if OP and PV seem to belong together.")
    no_response: NoResponse | None = about(
        "The behaviour of a PV that does not respond; None if the PV seems to respond."
    )
    few_slips: FewSlips | None = about(
        "Observed and needed slips of a valve that looks stuck but slips too rarely to decide; None for other valves."
    )
    windows: list[Window] = about("The results of the windows of the judged segment, in order of time.")
    notes: list[str] = about("Notes for the user on the file or the diagnosis.")

    _documented_as: ClassVar[Mapping[str, str]] = {
        "name": "loop",
        "loop_type": "type",
        "findings": "detectors",
    }


@result
class Judged(Result):
    """The part of a recording that was judged."""

    from_s: float = about("Time of the first sample of the segment, s on the recording's clock.")
    duration_s: float = about("Duration, s.")
    sample_time_s: float = about("Time between samples, s.")
    samples: int = about("Number of samples.")
    bridged: int = about("Number of missing samples that were bridged.")
    segments: int = about("Number of segments of the recording.")
    signals: list[str] = about("The recorded signals.")


@result
class PlantTime(Result):
    """The clock for the times of a recording: the plant's clock at the beginning. The offset stays unchanged across
    a change to or from summer time, so that the times stay in order.
    """

    name: str = about("Name of the clock, such as `CET`, `+05:30` or `UTC`; empty if the name was not recorded.")
    offset_s: int = about("Offset of the clock from UTC, s. If the name is unknown, times were interpreted as UTC.")


@result
class Mended(Result):
    """A kind of repair of the data, and how often it was necessary."""

    signal: str = about("The repaired signal, such as `PV`, or `time` if all signals were repaired.")
    count: int = about("Number of repaired samples, or of repaired steps of the clock.")
    first_s: float = about("Time of the first repair, s on the recording's clock.")
    done: str = about("The repair in a sentence.")


@result
class Masked(Result):
    """The samples of one signal that have the same value and count as missing."""

    signal: str = about("The signal, such as `PV`.")
    value: float = about("The recorded value.")
    count: int = about("Number of samples with this value.")
    first_s: float = about("Time of the first sample with this value, s on the recording's clock.")
    kind: str = about("Why the value is no measurement.")


@result
class SignalRange(Result):
    """The instrument range of a signal: the values at 0 % and 100 %."""

    low: float = about("The value at 0 %.")
    high: float = about("The value at 100 %.")
    source: str = about("Source of the range.")
    spans: list[float] = about(
        "The narrowest and the widest plausible span, in the unit of the signal. If the range is known, both values "
        "equal the span of the range."
    )


@result
class Fitness(Result):
    """Whether a recording is fit for a diagnosis, and why."""

    class_: str = about("The worst class among all measures.", kind='{"fit", "caveats", "unfit"}')
    reasons: list[str] = about("Why the recording is not fit: a sentence for each bad measure, the worst first.")
    measures: list[Measure] = about("All measures of the data.")


@result
class Measure(Result):
    """A measure of the fitness of the data."""

    name: str = about("A short name, such as `samples per cycle`.")
    value: float | None = about("Value; None if the data do not determine the value.")
    unit: str = about("Unit of value and thresholds; empty for a ratio.")
    caveat_at: float | None = about(
        "Limit beyond which the data have a caveat: an upper or a lower limit, depending on the measure."
    )
    unfit_at: float | None = about("Limit beyond which the data are unfit.")
    class_: str = about("Class of the data by this measure.", kind='{"fit", "caveats", "unfit"}')
    reason: str = about("The result of the measure in a sentence with numbers.")


@result
class Oscillation(Result):
    """Whether and how a signal oscillates. Times are in s from the first sample, or in a diagnosis in s on the
    recording's clock.
    """

    found: bool = about("Whether the signal oscillates.")
    basis: str | None = about(
        "The method that found the oscillation.", kind='{"autocorrelation", "spectral peak"} or None'
    )
    period_s: float | None = about("Period of the dominant oscillation, s; None without an oscillation.")
    amplitude: float | None = about(
        "The median over the periods of half of the peak-to-peak value, without noise, in the signal's units."
    )
    cycles: float | None = about("Number of periods in the signal.")
    regularity: float | None = about(
        "Regularity r of the zero crossings of the autocorrelation (Thornhill, Huang and Zhang, 2003); above 1, the "
        "oscillation is regular."
    )
    intervals: int = about("Number of intervals between zero crossings from which r is calculated; 0 without r.")
    decay_ratio: float | None = about(
        "Decay ratio R of the autocorrelation (Miao and Seborg, 1999); above 0.5, the signal is oscillatory."
    )
    supervision: Supervision | None = about(
        "The result of the supervision of half waves (Hägglund, 1995). The ultimate period is the detected period, and "
        "the amplitude is three standard deviations of the noise. None without an oscillation, or with fewer than 8 "
        "samples per period, because noise then looks like signal."
    )
    peaks: list[Peak] = about("All significant oscillations in the spectrum, the largest share of the variance first.")
    episodes: list[Episode] = about("Time spans of the dominant oscillation.")
    reasons: list[str] = about("The reasons for the result, in sentences with numbers.")


@result
class Supervision(Result):
    """The result of the supervision of half waves (Hägglund, 1995)."""

    threshold: float = about(
        "The smallest integral of the absolute error of a half wave that counts as a load disturbance, in units of the "
        "error times s."
    )
    disturbances: int = about("Number of half waves that count as load disturbances.")
    half_waves: int = about("Number of all half waves.")
    counter: float = about("The largest value of the forgetting counter.")
    alarm_s: float | None = about(
        "Time when the counter first exceeded the limit, s from the first sample; None if the counter stayed below the "
        "limit."
    )
    oscillates: bool = about("Whether the loop oscillates, which means that the counter exceeded the limit.")


@result
class Peak(Result):
    """An oscillation of a signal: a significant peak of the spectrum, and the band around the peak."""

    period_s: float = about(
        "Period, s: from the autocorrelation of the band, or from the peak if the autocorrelation has too few zero "
        "crossings."
    )
    amplitude: float = about("Amplitude of a sine with the power of the band, in the signal's units.")
    share: float = about(
        "Share of the band in the variance of the signal without drift. Everything with fewer than three periods in "
        "the signal is drift."
    )
    regularity: float | None = about(
        "Regularity r of the band. A band-pass makes noise look regular, so r counts only together with the peak's "
        "significance."
    )
    decay_ratio: float | None = about("Decay ratio R of the band; in a band with only noise, R is below 0.5.")
    chance: float = about("Probability that noise has such a peak at any frequency.")
    over_background: float = about("Power of the peak relative to the power of the background.")
    harmonic: int | None = about(
        "Number of the harmonic, if the oscillation is a harmonic of a stronger oscillation; else None."
    )
    band: tuple[float, float] = about("Lower and upper end of the band, cycles per sample.")
    is_oscillation: bool = about(
        "Whether the oscillation is separate: r exceeds 1, R exceeds 0.5, the share is at least 0.1 (our choice), and "
        "the oscillation is no harmonic."
    )


@result
class Episode(Result):
    """A time span with oscillation."""

    from_s: float = about("Beginning, s from the first sample.")
    to_s: float = about("End, s from the first sample.")
    half_waves: int = about("Number of half waves in the time span.")
    amplitude: float = about("Median height of the half waves, in the signal's units.")


@result
class Parameter(Result):
    """A named number."""

    name: str = about("Name, such as `delta tau`.")
    value: float = about("Value.")
    unit: str = about("Unit; empty for a ratio or a count.")


@result
class Kpi(Result):
    """One key figure of a loop."""

    name: str = about("Name, such as `OP travel`.")
    value: float | None = about("Value; None if the data do not determine the value.")
    unit: str = about("Unit; empty for a ratio, `PV` for the units of the process value.")
    meaning: str = about("Meaning of the key figure, in a sentence.")
    note: str | None = about("The reason for a missing value, or the assumption behind a value.")


@result
class Relation(Result):
    """A likely mistake in the columns of a recording."""

    mismatch: str = about("The mistake, such as `PV and OP look exchanged`.")
    because: str = about("The evidence for the mistake.")
    remedy: str = about("How to correct the mistake.")


@result
class NoResponse(Result):
    """The behaviour of a PV that does not respond to the OP."""

    silence: str = about(
        "The behaviour of the PV: `PV at its low end`, `PV at its high end`, `PV frozen` or `PV moves without the OP`."
    )
    decides: bool = about("Whether the verdict is based on this behaviour.")
    rest: Rest | None = about("The time in which the PV rests and the OP travels farthest; None if the PV moves.")
    faults: list[Fault] = about("Possible faults, the likeliest first.")


@result
class Rest(Result):
    """A time in which the PV rests, away from its set point, while the OP travels."""

    from_s: float = about("Beginning, s on the recording's clock.")
    to_s: float = about("End, s on the recording's clock.")
    op_travel: float = about("OP travel in this time, percent.")
    error: float = about("Mean of SP less PV in this time, in units of the PV.")
    overwhelming: bool = about("Whether this time alone is enough to name the fault.")


@result
class Fault(Result):
    """A possible fault that explains why the PV does not respond."""

    name: str = about("Name, such as `line isolated`.")
    told_by: str = about("How to distinguish this fault from the others.")


@result
class Verdict(Result):
    """The conclusion on a valve, with the basis and the reasons."""

    class_: str = about("The conclusion: `sticks`, `does not stick`, `does not respond` or `cannot tell`.")
    grade: str = about(
        "The grade of the verdict. The conclusion `cannot tell` has the grades `probably sticks`, `unclear`, `probably "
        "fine`, `too little to matter` and `data cannot answer`. The conclusion `does not stick` has the grades `fine` "
        "and `no stiction visible`. The grades `sticks` and `does not respond` are also conclusions."
    )
    probability: float | None = about(
        "The probability of stiction that the recording can show; None if no calibrated model gives a probability."
    )
    basis: str = about("The basis of the conclusion, such as `evidence in OP and PV`.")
    S_below: Limit | None = about(
        "The detection limit of this recording: a larger S is ruled out with the given confidence. The limit is given "
        "if the valve is cleared or nothing is decided. None if the valve is at fault, or S has an interval. None also "
        "for mistaken columns, unfit data, a recording unlike the training loops, or an unknown limit."
    )
    votes: Votes = about("The votes of the families of methods.")
    reasons: list[str] = about("The reasons for the conclusion, in sentences.")
    contradictions: list[str] = about("Evidence against the conclusion, in sentences.")
    alternatives: list[Alternative] = about("Other possible causes, the likeliest first.")
    confirm: TestPlan | None = about(
        "The manual test that would decide, as `stiction test plan` plans it. None if no test is needed, or `no_test` "
        "gives a reason."
    )
    no_test: str | None = about("Why a needed test is not possible.")

    _left_out: ClassVar[Mapping[str, str]] = {
        "override": "the command keeps the conclusions of people",
    }


@result
class Limit(Result):
    """An upper limit of S with its confidence."""

    value: float = about("The limit of S, percent of span.")
    confidence: float = about("Share of valves with a larger S that would have been detected.")


@result
class Votes(Result):
    """The numbers of families of methods by vote."""

    sticks: int = about("Number of families that find stiction.")
    does_not_stick: int = about("Number of families that find no stiction.")
    undecided: int = about("Number of families that apply, but are undecided or divided.")
    abstains: int = about("Number of families whose methods all abstain.")


@result
class Alternative(Result):
    """A possible cause other than the conclusion."""

    cause: str = about("The cause, such as `aggressive tuning`.")
    likelihood: float = about(
        "Probability of the cause. The probabilities of sticking and of all other causes add up to one."
    )
    because: str = about("The evidence for the cause, and how to distinguish the cause from others, in a sentence.")


@result
class TestPlan(Result):
    """The plan of a valve test, with sizes for one loop."""

    name: str = about("Tag of the loop.")
    pv_unit: str | None = about("Unit of the PV, if known.")
    each: int = about("Number of turns of each size.")
    grow: list[Turn] = about("The turns of the first part, in order. The first part ends when the PV responds.")
    shrink_by: float = about("Factor from one size of the second part to the next size.")
    ends_after: int = about("Number of consecutive sizes without a response after which the second part ends.")
    answer: float = about("The PV change that counts as a response, in PV units.")
    rises: bool | None = about(
        "Whether the PV rises when the OP rises; None if the recording does not show the direction."
    )
    pv_low: float = about("PV below which the controller goes back to automatic, in PV units.")
    pv_high: float = about("PV above which the controller goes back to automatic, in PV units.")
    op_low: float = about("The lowest OP of the test, percent.")
    op_high: float = about("The highest OP of the test, percent.")
    record_every_s: float = about("The longest permitted sample interval of OP and PV, s, without compression.")
    total_s: float = about("The longest time in manual, s, after which the test ends.")
    expected_s: float = about("The expected time in manual, s.")
    summary: str = about("A summary of the test.")
    instructions: list[str] = about("The instructions, in order.")


@result
class Turn(Result):
    """A turn of the OP in the plan of a test."""

    op: float = about("The OP relative to the OP before the test, percent of span.")
    hold_s: float = about("The longest hold after the turn, s.")


@result
class Stiction(Result):
    """The size of a valve's stiction."""

    S: Estimate | None = about("Stick band plus dead band, percent of span.")
    J: Estimate | None = about("Slip jump, percent of span.")
    coverage: float | None = about(
        "The nominal coverage of the intervals, such as 0.9; None for intervals without a nominal coverage."
    )
    model: str | None = about("The source of the numbers: the valve model, or the measured position.")
    why_not: str | None = about("Why S or J is missing.")
    definitions: list[Definition] = about('The values by the competing definitions of "stiction in percent".')


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
    value: float | None = about("Value; None if the data do not determine the value.")
    unit: str = about("Unit.")
    meaning: str = about("Meaning and source of the definition.")


@result
class FewSlips(Result):
    """The number of slips of a valve that looks stuck but slips too rarely to decide."""

    seen: int = about("Number of slips of the best valve model in all windows, scaled to the whole record.")
    needed: int = about("Number of slips that a decision needs.")
    step: float = about("Size of OP steps that would make the valve slip, percent of span: 1.5 times the estimated S.")
    words: str = about("Numbers of slips and size of the OP steps, in a sentence.")


@result
class ValveChange(Result):
    """A change of a valve between two windows."""

    change: str = about("The kind of change.")
    time_s: float = about("Time of the first window after the change, s.")
    interval_s: list[float] = about("The 95 % interval of the time of the change, s.")
    found_s: float = about("Time of the window with which the change was found, s.")


@result
class Window(Result):
    """The result of one window of a segment."""

    from_s: float = about("Time of the first sample of the window, s on the recording's clock.")
    duration_s: float = about("Duration, s.")
    probability: float = about("The probability that the valve sticks.")
    S: Estimate | None = about("Stick band plus dead band, percent of span; None if S could not be quantified.")
    J: Estimate | None = about("Slip jump, percent of span; None if J could not be quantified.")
    S_below: Limit | None = about(
        "The detection limit (95 %), percent of span: a larger S would have been visible in this window."
    )


@result
class Observation(Result):
    """The result of one recording or one window of a valve."""

    time_s: float = about("Time, s on a clock that all observations share.")
    class_: str = about("The conclusion.")
    probability: float | None = about("The probability that the valve sticks; None if unknown.", default=None)
    S: Estimate | None = about("Stick band plus dead band, percent of span; None if unknown.", default=None)
    J: Estimate | None = about("Slip jump, percent of span; None if unknown.", default=None)
    weight: float = about(
        "Weight of an observation, such as the number of cycles, if the majority decides or no observation has a pool. "
        "An observation of weight 0 does not count.", default=1.0
    )
    windows: float = about(
        "Number of windows in the observation, with overlaps counted once; 1 for a short recording.", default=1.0
    )
    grade: str | None = about(
        "The grade of the verdict; None for the grade that follows from conclusion and probability.", default=None
    )
    pool: str | None = about(
        "The combined evidence of the windows, which adds to the evidence of other observations as if all were one "
        "recording. None without a PV, or if the probability is not from the windows.", default=None
    )


@result
class History(Result):
    """The combined observations of one valve in its present state."""

    class_: str = about(
        "The conclusion by the combined probability; without a combined probability, the conclusion with more than "
        "half of the weight of all decisions."
    )
    grade: str = about("The grade of the conclusion, as in `Verdict`.")
    probability: float | None = about("The combined probability that the valve sticks; None if no observation has one.")
    observations: int = about("Number of observations since the last change of the valve.")
    decided: int = about(
        "Number of observations since the last change of the valve that decided or have a probability."
    )
    changes: list[ValveChange] = about(
        "The changes of the valve. Observations before the valve last began or ceased to stick do not count."
    )
    drift: Drift | None = about("The drift of S; None with too few observations of S.")
    trend: str = about("The drift of S in a sentence.")

    _documented_as: ClassVar[Mapping[str, str]] = {
        "observations": "windows",
    }


@result
class Drift(Result):
    """The drift of S."""

    per_day: float = about("Growth of S as a share of S, 1/day; 0.01 is 1 % a day.")
    low: float = about("Lower end of the 95 % interval of the growth, 1/day.")
    high: float = about("Upper end of the 95 % interval of the growth, 1/day.")
    p_value: float = about(
        "Two-sided p-value of the growth: the probability of a growth of this size or more if S does not drift."
    )
    robust_per_day: float = about("Growth of S by the median of the slopes of all pairs of observations, 1/day.")
    robust_p_value: float = about("p-value of Mann and Kendall's test.")
    significant: bool = about("Whether both tests and both slopes show that S drifts.")


@result
class RepairEffect(Result):
    """The effect of a repair on a valve."""

    time_s: float = about("Time of the repair, s on the clock of the observations.")
    outcome: str = about("The outcome.", kind='{"worked", "helped", "no change", "worse", "cannot tell"}')
    words: str = about("The outcome of the repair in a sentence.")
    before: int = about("Number of observations before the repair.")
    after: int = about("Number of observations after the repair.")
    probability: Contrast | None = about(
        "The probability that the valve sticks before and after the repair, by mean log-odds; None with too few "
        "observations."
    )
    S: Contrast | None = about(
        "S before and after the repair, percent of span, by geometric means; None with too few observations."
    )


@result
class Contrast(Result):
    """A quantity before and after a repair."""

    before_count: int = about("Number of observations of the quantity before the repair.")
    after_count: int = about("Number of observations of the quantity after the repair.")
    before: float = about("Typical value before the repair.")
    after: float = about("Typical value after the repair.")
    p_value: float = about("Two-sided p-value: the probability of a difference of this size or more by chance.")
    delta: float = about("Cliff's delta: from -1 (all fell) to 1 (all rose).")
    significant: bool = about("Whether the difference is significant, with a correction for two tests.")


@result
class OperatingPoint(Result):
    """The operating point of a loop."""

    op: float = about("Mean of the OP, percent.")
    pv: float = about("Mean of the PV, in PV units.")
    op_drift_per_hour: float = about("Slope of the OP, percent per hour, which shows the drift of the load.")


@result
class FittedController(Result):
    """A controller identified from its output."""

    structure: str = about("Structure.", kind='{"P", "PI", "PID"}')
    kc: Estimate = about("Gain, percent of OP per unit of PV; negative for a direct-acting controller.")
    ti: Estimate | None = about("Integral time, s; None without integral action.")
    td: Estimate | None = about("Derivative time, s; None without derivative action.")
    filter: float | None = about("Time constant of the derivative's filter, s.")
    set_point_weight: float | None = about(
        "Weight of the set point in the proportional part; None if the set point does not move."
    )
    set_point: Estimate | None = about(
        "The identified constant set point, in PV units; None if a set point is recorded."
    )
    gap: float = about("Control error up to which the controller does not act, in PV units; 0 without such a gap.")
    execution: float | None = about(
        "Time between executions, s; None if this time is shorter than the record can show."
    )
    delay_samples: int = about("Delay from the PV to the response of the OP, samples: 0 or 1.")
    low: float | None = about("The lower limit of the OP, percent; None if the OP did not reach a lower limit.")
    high: float | None = about("The upper limit of the OP, percent; None if the OP did not reach an upper limit.")
    rate_limit: float | None = about(
        "The fastest movement of the OP, percent per second; None if the OP seldom moved this fast."
    )
    op_quantum: float = about("Resolution of the recorded OP, percent; 0 if none is visible.")
    explained: float = about("Share of the OP's innovations that the controller explains.")
    otherwise: float = about(
        "Share of the samples at which something other than the controller moved the OP, such as an operator, "
        "tracking, or a fault of the record."
    )


@result
class FittedProcess(Result):
    """A process identified from the PV and from OP or valve position."""

    kind: str = about("Behaviour under a constant input.", kind='{"self-regulating", "integrating"}')
    gain: Estimate | None = about(
        "Gain, PV units per percent; None for an integrating process, or if the data do not separate gain and lag."
    )
    tau: Estimate | None = about("Time constant, s; None if the gain is None.")
    slope: Estimate = about(
        "Initial slope of the PV after a step of one percent, PV units per second. The slope is gain over lag, and may "
        "be known even if gain and lag are not."
    )
    delay: Estimate = about("Dead time with all small lags, s.")
    explained: float = about("Share of the PV's innovations that the input explains.")
    jointly: str | None = about("What the data cannot identify, in a sentence; None if everything is identified.")
    disturbance_sd: float = about("Standard deviation of the disturbance of the PV, in PV units.")
    innovation_sd: float = about(
        "Standard deviation of the disturbance's innovations from sample to sample, in PV units."
    )


@result
class FittedValve(Result):
    """A valve identified from a recording."""

    model: str | None = about("Valve model; None if all possible valves follow the OP.")
    S: Estimate = about("Stick band plus dead band if the valve sticks, percent of span.")
    J: Estimate = about("Slip jump if the valve sticks, percent of span.")
    follows: float = about("Weight of the valves that follow the OP among all possible valves, from 0 to 1.")
    from_: str = about("Source of S and J.")


@result
class FittedCycle(Result):
    """The recorded swing, the limit cycle of the fitted loop, and the swing if the valve followed the OP."""

    recorded: RecordedSwing | None = about("The recorded oscillation; None if nothing oscillates.")
    predicted: PredictedSwing | None = about(
        "The predicted oscillation; None if hardly any drawn loop has a limit cycle."
    )
    cycling: float = about("Share of the drawn loops that have a limit cycle.")
    pv_swing_left: Estimate | None = about(
        "Share of the PV's amplitude near the period that would remain if the valve followed the OP. None if nothing "
        "oscillates, or the share could not be computed."
    )
    explained: bool | None = about(
        "Whether the valve explains the swing: the fitted loop has the recorded cycle, or most of the swing would "
        "vanish if the valve followed the OP. None if nothing oscillates."
    )
    sentence: str = about("Whether and why the valve explains the swing, in a sentence.")


@result
class RecordedSwing(Result):
    """The recorded oscillation of a loop."""

    period_s: float = about("Period, s.")
    op: float = about("Amplitude of the OP, percent of span, as defined for `Oscillation`.")
    pv: float = about("Amplitude of the PV about the set point, in PV units, as defined for `Oscillation`.")


@result
class PredictedSwing(Result):
    """The limit cycle of the fitted loop without disturbances."""

    period_s: Estimate = about("Period of the limit cycle, s.")
    op: Estimate = about("Half of the OP's peak-to-peak value, percent of span.")
    pv: Estimate = about("Half of the PV's peak-to-peak value, in PV units.")


@result
class RankedProspects(Result):
    """Possible actions on a recorded loop, the best first."""

    actions: list[Prospect] = about(
        "The actions, in ascending order of the upper end of the ratio of the control error, and then of effort."
    )
    loops: int = about("Number of simulated loops.")
    advice: list[str] = about("The advice, in sentences.")


@result
class Prospect(Result):
    """The effect of an action. The ends of intervals are the 5 and 95 % points of the drawn loops."""

    action: str = about(
        "The action: `as it is`, `valve repaired`, `retuned`, `repaired and retuned`, `positioner`, or the name of a "
        "compensator."
    )
    pv_swing: Estimate = about("Amplitude of the PV about the set point, in PV units, as defined for `Oscillation`.")
    pv_swing_ratio: Estimate = about(
        "Ratio of the PV swing to the PV swing of the present loop, for each drawn loop; larger ratios than 20 count "
        "as 20."
    )
    error: Estimate = about("Mean absolute control error, in units of the PV.")
    error_ratio: Estimate = about(
        "Ratio of the control error to the control error of the present loop, for each drawn loop; larger ratios than "
        "20 count as 20."
    )
    travel: Estimate = about("Valve travel, percent of span per hour.")
    settling_s: Estimate | None = about("Time to settle after a load step, s; None if half of the loops do not settle.")
    sure: float = about(
        "Probability that the PV swing falls by more than 20 %. The benefit is called certain from 0.95 on, and "
        "probable above 0.5."
    )
    tuning: Proposal | None = about("The tuning of an action that retunes the controller; None for other actions.")


@result
class Proposal(Result):
    """A proposed tuning."""

    kc: float = about("Gain, percent per PV unit.")
    ti: float = about("Integral time, s.")
    ms: Estimate = about(
        "Peak of the sensitivity function (Ms) with this tuning, over all drawn loops; a loop with 2 or less is "
        "robust."
    )
    rule: str = about("The tuning rule.")

    _documented_as: ClassVar[Mapping[str, str]] = {
        "ms": "Ms",
    }


@result
class TestReading(Result):
    """The result of a valve test."""

    class_: str = about(
        "The conclusion from the test and the operation before the test: `sticks`, `does not stick`, `does not "
        "respond` or `cannot tell`."
    )
    probability: float = about("Probability that the valve sticks, from the test and the operation before the test.")
    by_test: float = about("Probability that the valve sticks, from the test alone.")
    by_operation: float | None = about(
        "Probability that the valve sticks, from the operation before the test; None if the operation gives no "
        "probability."
    )
    dead_band_elsewhere: float = about(
        "Probability of a dead band downstream of the valve, in the process, a linkage or the transmitter."
    )
    S: Estimate | None = about(
        "Stick band plus dead band, percent of span, with its 90 % interval, if the valve sticks."
    )
    J: Estimate | None = about("Slip jump, percent of span, with its 90 % interval, if the valve sticks.")
    S_below: float | None = about(
        "Upper limit of S with 95 % confidence, percent of span; None if the test gives no limit."
    )
    response_s: float | None = about(
        "Sum of dead time and lags between OP and PV, s; None if no turn had a response, or the test was shorter than "
        "this sum."
    )
    known_by: str = about("The source of the manual settings: `sheet`, `mode` or `output`.")
    from_s: float = about("Start of the test, s on the recording's clock.")
    to_s: float = about("End of the test, s on the recording's clock.")
    stops: int = about("Number of times that the controller took over during the test.")
    by_position: bool = about("Whether the responses are read from the recorded valve position instead of the PV.")
    position: PositionReading | None = about("Results from the valve position; None without a recorded valve position.")
    steps: list[Step] = about("The turns of the test, in order.")
    reasons: list[str] = about("The reasons, in sentences.")
    advice: str | None = about("How to repeat an inconclusive test.")
    plan: PlanComparison | None = about("The comparison with the plan; None if no plan was given.")


@result
class PositionReading(Result):
    """Results from the stem position, by the definitions of ANSI/ISA-75.25.01 (recalled)."""

    dead_band: Between | None = about(
        "The OP change after a reversal at which the stem begins to move, percent; None without a reversal."
    )
    resolution: Between | None = about(
        "The OP change in one direction at which the stem moves again, percent; None if each turn is a reversal."
    )
    dead_time_s: float | None = about(
        "Median time until the stem begins to move, s; None if no turn moved the stem by 2 % or more."
    )
    t63_s: float | None = about("Median time until the stem has covered 63.2 % of the travel, s.")
    t86_s: float | None = about("Median time until the stem has covered 86.5 % of the travel, s.")
    timed: int = about("Number of turns in the medians of the times.")


@result
class Between(Result):
    """The OP change that moves the stem, percent, as an interval between two turns."""

    above: float = about("The largest change that did not move the stem; 0 if every change moved it.")
    up_to: float | None = about("The smallest change that moved the stem; None if none did.")


@result
class Step(Result):
    """A turn of the OP in a test, and the response of the PV."""

    at_s: float = about("Time of the OP setting, s on the recording's clock.")
    op: float = about("The OP after the turn, percent.")
    travel: float | None = about(
        "The change of the OP, percent. None for the first turn of a time in manual, because the stem position before "
        "the turn is unknown, and for a turn without a change of the OP."
    )
    answer: float | None = about(
        "The PV change, in PV units, until the next turn. If the process needs longer to respond, the PV change until "
        "the process has responded."
    )
    error: float | None = about("Standard deviation of the PV change, in PV units.")
    answered: bool = about("Whether the PV moved in the expected direction by more than 2.5 standard deviations.")


@result
class PlanComparison(Result):
    """A test compared with its plan."""

    sizes: list[SizeComparison] = about("The sizes of turns, in the order of the test or of the plan.")
    turns_planned: int = about("Number of planned turns of the compared sizes.")
    turns: int = about("Number of turns in the test.")
    cut_short: int = about(
        "Number of turns of part 1 that ended before the planned hold, although the PV had not responded."
    )
    held_longer: int = about("Number of turns of part 1 that were held longer than planned.")
    pv_beyond_s: float = about("Time in the test with the PV outside the limits of the plan, s.")
    pv_low: float = about("The lowest PV of the test, in PV units.")
    pv_high: float = about("The highest PV of the test, in PV units.")
    remarks: list[str] = about("Deviations from the plan in sentences, or a sentence that there are no deviations.")


@result
class SizeComparison(Result):
    """A size of turns in the plan and in the test."""

    part: int = about("The part of the test: 1 with growing sizes, 2 with shrinking sizes.")
    planned: float | None = about(
        "The planned size, percent from one turn to the next; None if the plan lacks the size."
    )
    made: float | None = about("The actual size, percent; None if the test lacks the size.")
    turns: int = about("Number of turns of this size in the test.")
    answered: int = about("Number of turns of this size to which the PV responded.")
    hold_planned_s: float | None = about(
        "The longest planned hold, s; None in part 2, where the hold depends on the responses."
    )
    hold_s: float | None = about("The longest actual hold, s; None if the test lacks the size.")


@result
class Difference(Result):
    """S after a repair minus S before the repair."""

    value: float | None = about("The best value, percent of span; None if a test gives only a limit of S.")
    low: float = about("Lower end of the 90 % interval of the difference, percent of span.")
    high: float = about("Upper end of the 90 % interval of the difference, percent of span.")


@result
class SignaturePlan(Result):
    """The plan of a signature: slow ramps of the OP over the stroke."""

    name: str = about("Tag of the loop.")
    from_op: float = about("The OP at the start, percent.")
    ramps: list[Ramp] = about("The ramps, in order.")
    record_every_s: float = about("The longest permitted sample interval of OP and VP, s, without compression.")
    total_s: float = about("Duration of all ramps and holds, s.")
    summary: str = about("A summary of the signature.")
    instructions: list[str] = about("The instructions, in order.")


@result
class Ramp(Result):
    """A ramp of the OP in the plan of a signature."""

    to_op: float = about("The OP at the end of the ramp, percent.")
    duration_s: float = about("Duration of the ramp, s.")
    hold_s: float = about("Duration of the hold at the end of the ramp, s.")


@result
class SignatureReading(Result):
    """The result of a signature."""

    class_: str = about("The conclusion: `sticks`, `does not stick`, `does not respond` or `cannot tell`.")
    S: Estimate | None = about(
        "Stick band plus dead band, percent of span, with its 90 % interval, outside the part of the stroke that "
        "binds."
    )
    J: Estimate | None = about("Slip jump, percent of span, with its 90 % interval; None without S.")
    op: list[float] = about("The OP range of the ramps, percent.")
    vp: list[float] = about(
        "The range of the valve position, percent. Without a recorded valve position, the range of the PV as a "
        "position."
    )
    offset: float = about("The calibration error: the mean of the simulated stem position minus VP, percent.")
    places: list[Place] = about("The parts of the stroke, from the lowest part on.")
    binds: list[float] | None = about(
        "The part of the stroke where the stem binds, which means that S is clearly larger there; None without such a "
        "part."
    )
    ramps: int = about("Number of ramps.")
    from_s: float = about("Start of the ramps, s on the recording's clock.")
    to_s: float = about("End of the ramps, s on the recording's clock.")
    reasons: list[str] = about("The reasons, in sentences.")


@result
class Place(Result):
    """A part of the stroke with its S."""

    from_: float = about("The stem position at the lower end of the part, percent.")
    to: float = about("The stem position at the upper end of the part, percent.")
    S: Estimate = about("Stick band plus dead band in this part, percent of span, with its 90 % interval.")


@result
class Checked(Result):
    """The files and loops of a plant, and the problems in both."""

    plant: str = about("Name of the plant.")
    files: int = about("Number of files that the plant's file names.")
    loops: list[LoopThere] = about("The loops in the files.")
    problems: list[Problem] = about("Files and loops that could not be read.")
    unknown: list[Unknown] = about(
        "Files and loops that could not be read, loops without a PV, and tags without a partner."
    )
    no_recordings: list[str] = about("Files that are no recordings because they have no OP, with a sentence on each.")


@result
class LoopThere(Result):
    """A loop in the data of a plant."""

    loop: str = about("Tag of the loop.")
    days: int = about("Number of days with samples.")
    first_day: str | None = about("The first day with samples.")
    last_day: str | None = about("The last day with samples.")
    in_plant_file: bool = about("Whether the loop is in the plant's file.")
    tags: list[str] = about('Tags of the signals in the last file of the loop, such as `op = "FIC101.OP"`.')
    op_range: list[float] | None = about("The values of the OP at 0 % and 100 %.", kind='list of two floats or None')
    modes: list[str] = about(
        "The recorded modes: `auto`, `cascade`, `manual`, `other`; empty without a record of the mode."
    )
    notes: list[str] = about("Assumptions about the loop, and points to confirm.")


@result
class Problem(Result):
    """A file or loop that could not be read."""

    file: str | None = about("The file; None if the problem concerns all files.")
    loop: str | None = about("The loop; None if the problem concerns the whole file.")
    message: str = about("The fault and the remedy.")


@result
class Unknown(Result):
    """A file, loop, tag or window that could not be used, with the reason."""

    kind: str = about(
        "Kind: `file not read`, `loop not read`, `loop without a PV`, `tag without a partner` or `window not judged`."
    )
    name: str = about("Name of the file, loop or tag.")
    count: int = about("Number of windows of a loop that were not judged; 1 for all other kinds.")
    reason: str = about("The reason, with a remedy.")


@result
class Status(Result):
    """The results of a plant so far."""

    plant: str = about("Name of the plant.")
    loops: int = about("Number of loops with a window.")
    days: int = about("Number of days with a window.")
    first_day: str | None = about("The first day with a window.")
    last_day: str | None = about("The last day with a window.")
    windows: int = about("Number of valid windows.")
    errors: int = about("Number of windows that could not be judged.")
    time_limited: int = about("Number of windows that reached the time limit of their scan.")
    grades: list[Graded] = about("Number of windows by grade, the worst grade first.")
    runs: int = about("Number of runs.")
    cut_short: int = about("Number of incomplete runs since the last complete scan of all loops and days.")
    damaged: list[str] = about("Damaged files of the store, with a sentence on each.")
    changes: Changes = about("Data files that differ from the last scan.")
    unknown: list[Unknown] = about("Data that the last scan did not read, and all windows that could not be judged.")


@result
class Graded(Result):
    """The number of windows with a grade."""

    grade: str = about("The grade.")
    windows: int = about("Number of windows with this grade.")


@result
class Changes(Result):
    """Data files that differ from the last scan."""

    new: list[str] = about("Files that no scan has read.")
    changed: list[str] = about(
        "Files with different content. A different size or date counts as different content until a scan reads the "
        "file."
    )
    missing: list[str] = about("Files that no longer exist. The verdicts from these files stay.")


@result
class Scanned(Result):
    """The result of a scan of a plant."""

    plant: str = about("Name of the plant.")
    run: str | None = about("Name of the run; None if nothing was new.")
    engine_version: str = about("Version of the program.")
    model_version: str = about("Version of the trained model of the verdict.")
    files: int = about("Number of files that were examined.")
    loops: int = about("Number of loops in these files.")
    windows: int = about("Number of windows that were judged in this run.")
    errors: int = about("Number of windows of this run that could not be judged.")
    parts: int = about("Number of files of the store that hold the rows of this run.")
    problems: list[Problem] = about("Files and loops that could not be read.")
    unknown: list[Unknown] = about(
        "Files and loops that could not be read, loops without a PV, tags without a partner, and the windows of this "
        "run that were not judged."
    )
    no_recordings: list[str] = about("Files that are no recordings because they have no OP, with a sentence on each.")
    damaged: list[str] = about("Files of earlier runs that were found damaged, with a sentence on each.")
    changes: Changes = about("Data files that differ from the previous scan.")


@result
class Group(Result):
    """Loops that swing together, and the candidates for the source."""

    id: int = about("Number of the group, from 1.")
    period_s: float = about("Period of the swing, s.")
    members: list[Member] = about(
        "The loops of the group: first the candidates for the source by rank, then the other loops by coherence."
    )
    source: str = about("Whether a loop of the group may be the source.", kind='{"candidates", "not-recorded"}')
    reasons: list[str] = about("The evidence for the group, in sentences.")


@result
class Member(Result):
    """A loop of a group of loops that swing together."""

    loop: str = about("Tag of the loop.")
    coherence: float = about(
        "The share of the loop's swing at the period that is common to the group: squared coherence, 0 to 1."
    )
    candidate_rank: int | None = about(
        "Rank among the candidates for the source, from 1; None if the loop is no candidate."
    )
    reasons: list[str] = about("Evidence for and against this loop as the source, in sentences.")


@result
class Compensator(Result):
    """The description of a compensator."""

    name: str = about("Name in commands.")
    summary: str = about("Principle, in one line.")
    citation: str = about("Source of the compensator.")


@result
class FrictionLaw(Result):
    """The description of a friction law."""

    name: str = about("Name of the law in commands.")
    summary: str = about("Principle, in one line.")
    source: str = about("Source of the law, cited from memory and not verified unless stated otherwise.")
    parameters: list[str] = about("Names of the parameters, with units, in order.")


@result
class FmuModel(Result):
    """A model that can be exported as an FMU."""

    kind: str = about("The kind of the model: `valve`, `stem` or `loop`.")
    name: str = about("The valve model, or the friction law or parameter set of the stem.")
    summary: str = about("Description, in one line.")

    _documented_as: ClassVar[Mapping[str, str]] = {
        "kind": "model",
        "name": "law",
    }


@result
class FmuVariable(Result):
    """A variable of an FMU."""

    name: str = about("Name.")
    role: str = about(
        "Purpose: `time`, `input`, `output`, `parameter`, `tunable` (a parameter that may be changed while the "
        "simulation runs) or `local`."
    )
    start: float | bool | None = about(
        "Value at the start; None if the value is computed.", kind='float or int or bool or None'
    )
    unit: str = about("Unit; empty for a variable without a unit.")
    description: str = about("Description, in one line.")


@result
class Tuning(Result):
    """The gain, integral time and derivative time of a controller."""

    kc: float = about("Gain, percent per PV unit.")
    ti: float | None = about("Integral time, s; None without integral action.")
    td: float = about("Derivative time, s; 0 without derivative action.")


@result
class ValveModel(Result):
    """The description of a published valve model."""

    name: str = about("Name in commands.")
    aliases: list[str] = about("Other names.")
    summary: str = about("Principle, in one line.")
    citation: str = about("Source of the model.")
    uses_s: bool = about("Whether the model uses `S`.")
    uses_j: bool = about("Whether the model uses `J`.")
    uses_k: bool = about("Whether the model uses the overshoot `K` of a slip.")
    uses_rest_tolerance: bool = about("Whether the model uses a rest tolerance.")
