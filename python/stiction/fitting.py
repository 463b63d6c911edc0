"""The loop behind a recording: controller, process and valve; whether it explains the swing; and what would mend it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from stiction import _core, _plots
from stiction._arguments import choice, integer, optional, text
from stiction._core import Recording, Scenario
from stiction._result import Result, about, result, result_of
from stiction._words import drawn
from stiction.closed_loop import simulate
from stiction.compensation import compensators
from stiction.diagnosis import Estimate
from stiction.recordings import RecordingLike, Segment, _checked

__all__ = [
    "Fit",
    "FittedController",
    "FittedCycle",
    "FittedProcess",
    "FittedValve",
    "OperatingPoint",
    "PredictedSwing",
    "Proposal",
    "Prospect",
    "Prospects",
    "RecordedSwing",
    "Ring",
    "fit",
]

PARTS = ("controller", "process", "valve", "cycle")
DONE = ("nothing", "repair", "retune", "repair-and-retune", "positioner")
SHOWN = 1200
"""Samples of a recording that are drawn."""


@result
class OperatingPoint(Result):
    """What a recorded loop moves about."""

    op: float = about("Mean of the OP, percent of span.")
    pv: float = about("Mean of the PV, in its units.")
    op_drift_per_hour: float = about("Slope of the OP, percent of span per hour: how fast the load drifts.")


@result
class FittedController(Result):
    """A controller as its output shows it; intervals of 90 %."""

    structure: str = about("What it consists of.", kind='{"P", "PI", "PID"}')
    kc: Estimate = about("Gain, percent of the OP per unit of the PV; negative of a direct-acting controller.")
    ti: Estimate | None
    td: Estimate | None = about("Integral and derivative time, s; None without such action.")
    filter: float | None = about("Time constant of the derivative's filter, s.")
    set_point_weight: float | None = about(
        "Weight of the set point in the proportional part; None where the set point never moves."
    )
    set_point: Estimate | None = about("The constant set point, in units of the PV, where none is recorded.")
    gap: float = about(
        "Half the width of the gap within which the error counts for nothing, in units of the PV; 0 for none."
    )
    execution: float | None = about("Time between executions, s; None where it is shorter than the record can show.")
    delay_samples: int = about("Samples from a PV to the OP that answers it: 0 or 1.")
    low: float | None
    high: float | None = about("Limits of the OP, percent of span, where they were reached.")
    rate_limit: float | None = about(
        "The most that the OP moves, percent of span per second, where that was reached often."
    )
    op_quantum: float = about("Resolution of the recorded OP, percent of span; 0 where none shows.")
    explained: float = about("Share of what is new in the OP that it explains.")
    otherwise: float = about(
        "Share of the samples at which something else moved the OP: a hand, tracking, an upset of the record."
    )


@result
class FittedProcess(Result):
    """A process between valve and PV as the recording shows it; intervals of 90 %."""

    kind: str = about("What it does under a constant input.", kind='{"self-regulating", "integrating"}')
    gain: Estimate | None = about(
        "Units of the PV per percent; None of one that integrates, and where it is not known apart from the lag."
    )
    tau: Estimate | None = about("Time constant, s; None likewise.")
    slope: Estimate = about(
        "How fast the PV first moves after a step of one percent, units of the PV per second: gain over time "
        "constant, which is known where the two are not."
    )
    delay: Estimate = about("Dead time with all small lags, s.")
    explained: float = about("Share of what is new in the PV that the input explains.")
    jointly: str | None = about("What the data do not tell apart, in a sentence; None where they do.")
    disturbance_sd: float = about("Standard deviation of what disturbs the PV, in its units.")
    innovation_sd: float = about("Standard deviation of what is new in that from sample to sample.")


@result
class FittedValve(Result):
    """A valve as the recording shows it; intervals of 90 %."""

    model: str | None = about("Its model; None where every valve that is possible follows its OP.")
    S: Estimate = about("Stick band plus dead band if it sticks, percent of span.")
    J: Estimate = about("Slip jump if it sticks, percent of span.")
    follows: float = about("Weight of valves that follow their OP among all that are possible, from 0 to 1.")
    from_: str = about("What S and J come from.")


@result
class RecordedSwing(Result):
    """The swing that was recorded."""

    period_s: float = about("Its period, s.")
    op: float = about("Half of the OP's typical peak-to-peak value, percent of span.")
    pv: float = about("Half of the PV's typical peak-to-peak value, in its units.")


@result
class PredictedSwing(Result):
    """The limit cycle of a fitted loop."""

    period_s: Estimate = about("Its period, s.")
    op: Estimate = about("Half of the OP's peak-to-peak value, percent of span.")
    pv: Estimate = about("Half of the PV's peak-to-peak value, in its units.")


@result
class FittedCycle(Result):
    """The swing that was recorded beside what the fitted loop does by itself, and would do behind a valve that follows."""

    recorded: RecordedSwing | None = about("What was recorded; None where nothing oscillates.")
    predicted: PredictedSwing | None = about(
        "What the loop does by itself; None where hardly a loop that is possible cycles."
    )
    cycling: float = about("Share of the loops drawn that cycle at all, from 0 to 1.")
    pv_swing_left: Estimate | None = about(
        "Share of the PV's swing that would be left, had the valve followed its OP; None where nothing oscillates, "
        "and where it could not be computed."
    )
    explained: bool | None = about(
        "Whether the valve explains the swing: the fitted loop cycles as the recording does, or so much of the swing "
        "would be gone without the valve's sticking. None where nothing oscillates."
    )
    sentence: str = about("The same in words.")


@result
class Proposal(Result):
    """A tuning that is proposed."""

    kc: float = about("Gain, percent of the OP per unit of the PV.")
    ti: float = about("Integral time, s.")
    ms: Estimate = about("Peak of the sensitivity function with it, over all loops drawn; 2 and less is robust.")
    rule: str = about("The rule it comes from.")

    _documented_as: ClassVar[Mapping[str, str]] = {"ms": "Ms"}


@result
class Prospect(Result):
    """What an action would bring; intervals are the 5 and 95 % points of the loops drawn."""

    action: str = about(
        '``"as it is"``, ``"valve repaired"``, ``"retuned"``, ``"repaired and retuned"``, ``"positioner"``, or the '
        "name of a compensator."
    )
    pv_swing: Estimate = about("Half of the PV's peak-to-peak value, in its units.")
    pv_swing_ratio: Estimate = about("The same over that of the loop as it is, loop by loop.")
    error: Estimate = about("Mean absolute control error, in units of the PV.")
    error_ratio: Estimate = about("The same over that of the loop as it is, loop by loop.")
    travel: Estimate = about("Travel of the valve, percent of span per hour.")
    settling_s: Estimate | None = about(
        "Time to settle after a load step, s; None where half of the loops do not settle."
    )
    sure: float = about(
        "Share of the loops drawn in which the PV swings less than 0.8 times as much: from 0.95 on the benefit is "
        "called certain."
    )
    tuning: Proposal | None = about("The tuning that is meant, where it is one.")


@result
class Prospects(Result):
    """What could be done about a recorded loop."""

    actions: list[Prospect] = about(
        "The actions, the best first: by the upper end of the ratio of the control error, then by effort."
    )
    loops: int = about("How many loops that the recording leaves possible were simulated.")
    advice: list[str] = about("What to do, in sentences.")

    def _summary(self) -> list[str]:
        best = self.actions[0]
        return [
            f"Prospects of {len(self.actions)} actions, by {self.loops} loops that the recording leaves possible",
            f"best: {best.action}, PV swing {best.pv_swing.value:.2g} PV units ({best.pv_swing.low:.2g} to"
            f" {best.pv_swing.high:.2g})",
        ]

    @drawn(2)
    def plot(self, ax: Any = None) -> Any:
        """Draw the swing of the PV and the control error with every action, with their intervals."""
        made = _plots.axes(ax, 2, sharex=False, height=max(2.0, 0.33 * len(self.actions)))
        names = [row.action for row in self.actions]
        quantities = (
            ("half of the PV's peak-to-peak value (PV units)", [row.pv_swing for row in self.actions]),
            ("mean absolute control error (PV units)", [row.error for row in self.actions]),
        )
        for each, (label, found) in zip(made, quantities):
            colours = ["0.6" if name == "as it is" else "C0" for name in names]
            each.barh(names, [one.value for one in found], color=colours)
            each.hlines(names, [one.low for one in found], [one.high for one in found], color="k", linewidth=2)
            each.invert_yaxis()
            each.set_xlabel(label)
        return made


@result
class Ring(Result):
    """What was predicted of an action, and what came."""

    action: str = about("The action, as in `Prospect`.")
    before: float
    after: float = about("Half of the PV's peak-to-peak value before and after it, in its units.")
    predicted: Estimate = about("What was predicted of the latter.")
    as_predicted: bool = about("Whether it came within the predicted interval, or better.")
    sentence: str = about("The same in words.")


@result
class Fit(Result):
    """The loop behind a recording. Parts that could not be identified are None, and `why_not` says why."""

    name: str = about("Tag of the loop.")
    sample_time_s: float = about("Time between the samples that it was fitted to, s.")
    resting: OperatingPoint = about("What the loop moves about.")
    controller: FittedController | None = about("The controller.")
    process: FittedProcess | None = about("The process behind the valve.")
    valve: FittedValve | None = about("The valve.")
    cycle: FittedCycle | None = about("The limit cycle of that loop beside the swing that was recorded.")
    why_not: dict[str, str] = about(
        "Why a part could not be identified, by its name; empty where all were.",
        kind="dict of str",
    )

    @classmethod
    def _prepared(cls, document: Mapping[str, Any]) -> Mapping[str, Any]:
        # In documents a part is what it is, or why it is not identified.
        why = {part: document[part].get("not_identified") for part in PARTS}
        missing = {part: reason for part, reason in why.items() if reason is not None}
        return {**document, **dict.fromkeys(missing), "why_not": missing}

    def _summary(self) -> list[str]:
        parts = []
        if self.controller is not None:
            parts.append(f"controller: {self.controller.structure}, kc {self.controller.kc.value:.3g}")
        if self.valve is not None:
            parts.append(f"valve: S {self.valve.S.value:.2g} % of span, J {self.valve.J.value:.2g} %")
        if self.cycle is not None:
            explained = {True: "yes", False: "no", None: "there is none"}[self.cycle.explained]
            parts.append(f"swing explained by the valve: {explained}")
        missing = ", ".join(self.why_not)
        return [f"Fit of {self.name}", *parts, *([f"not identified: {missing}"] if missing else [])]

    @property
    def segment(self) -> Segment:
        """The signals that it was fitted to, on a regular grid."""
        return Segment(**_kept(self).segment())

    def scenario(self) -> Scenario:
        """Give the loop as a scenario, with the likeliest of its values.

        Returns
        -------
        Scenario
            For `simulate`, `limit_cycle`, `compensate`, `what_if`, `stiction.fmu.export` and all else that takes one.
            Its ``text`` is TOML, which says of each value where it comes from.

        Raises
        ------
        ValueError
            If controller, process or valve is not identified.

        Examples
        --------
        >>> import stiction
        >>> run = stiction.simulate("samples/sticky-flow")
        >>> found = stiction.fit(stiction.recording(run.op, run.pv, run.sp, sample_time=1))
        >>> cycle = stiction.limit_cycle(found.scenario()).cycle
        >>> abs(cycle.period_s / found.cycle.recorded.period_s - 1) < 0.25
        True
        """
        return _kept(self).scenario()

    def prospects(self) -> Prospects:
        """Simulate what could be done, on loops drawn from all that the recording leaves possible.

        Returns
        -------
        Prospects
            As it is, repaired, retuned, both, with a positioner, and with compensators that an ordinary controller
            can carry out.

        Raises
        ------
        ValueError
            If a part of the loop is not identified, or most of the valves that are possible follow their OP.

        Examples
        --------
        >>> import stiction
        >>> run = stiction.simulate("samples/sticky-flow")
        >>> found = stiction.fit(stiction.recording(run.op, run.pv, run.sp, sample_time=1)).prospects()
        >>> [repaired] = [row for row in found.actions if row.action == "valve repaired"]
        >>> repaired.pv_swing_ratio.value < 0.5, repaired.sure > 0.9
        (True, True)
        """
        return result_of(Prospects, _kept(self).prospects())

    def ring(self, after: Recording, action: str = "repair") -> Ring:
        """Set what was predicted of an action beside what was recorded after it.

        Parameters
        ----------
        after : Recording
            The same loop after something was done.
        action : str, default "repair"
            What was done: ``"nothing"``, ``"repair"``, ``"retune"``, ``"repair-and-retune"``, ``"positioner"``, or the
            name of a compensator, see `compensators`.

        Raises
        ------
        ValueError
            If nothing was predicted of that action, the loop did not oscillate before, or a recording has no PV that
            lasts for a period of that oscillation; or as for `prospects`.

        Examples
        --------
        >>> import stiction
        >>> def recorded(settings):
        ...     run = stiction.simulate("samples/sticky-flow", settings)
        ...     return stiction.recording(run.op, run.pv, run.sp, sample_time=1)
        >>> before, after = recorded({}), recorded({"valve.S": 0.4, "valve.J": 0.1})
        >>> stiction.fit(before).ring(after, "repair").as_predicted
        True
        """
        chosen = choice("action", action, [*DONE, *(each.name for each in compensators())])
        told = self.__dict__["_made_of"][1]
        return result_of(Ring, _kept(self).ring(_checked(after, "after"), told, chosen))

    @drawn(4)
    def plot(self, ax: Any = None) -> Any:
        """Draw PV and OP as recorded, and below in equal scales what the fitted loop does when it is simulated.

        At most 1,200 samples of the recording, from its middle; of the simulation as long a part, its end.

        Raises
        ------
        ValueError
            As for `scenario`.
        """
        run, segment = simulate(self.scenario()), self.segment
        made = _plots.axes(ax, 4)
        start = max(0, len(segment.op) - SHOWN) // 2
        shown = slice(start, start + SHOWN)
        time = segment.time_s[shown] - segment.time_s[start]
        last = slice(-max(1, round(len(time) * segment.sample_time / run.sample_time)), None)
        own_time = run.time_s[last] - run.time_s[last][0]
        _plots.pv_over_time(
            made[0],
            time,
            None if segment.sp is None else segment.sp[shown],
            None if segment.pv is None else segment.pv[shown],
            "recorded (PV units)",
        )
        made[1].plot(time, segment.op[shown], color="C0", linestyle="--", linewidth=1.2, label="OP")
        if segment.vp is not None:
            made[1].plot(time, segment.vp[shown], color="C3", label="VP")
        made[1].set_ylabel("recorded (% of span)")
        _plots.legend(made[1])
        _plots.pv_over_time(made[2], own_time, run.sp[last], run.pv[last], "fitted loop (PV units)")
        _plots.valve_over_time(made[3], own_time, run.op[last], run.vp[last], "fitted loop (% of span)")
        for recorded, fitted in ((made[0], made[2]), (made[1], made[3])):
            ends = [*recorded.get_ylim(), *fitted.get_ylim()]
            recorded.set_ylim(min(ends), max(ends))
            fitted.set_ylim(min(ends), max(ends))
        made[0].set_title(self.name, loc="left")
        return made

    def __getstate__(self) -> dict[str, Any]:
        # The handle is made again from the recording when it is asked for.
        return {key: value for key, value in self.__dict__.items() if key != "_handle"}


def fit(
    recording: RecordingLike,
    *,
    loop_type: str | None = None,
    sample_time: float | None = None,
    draws: int = 60,
    seed: int = 1,
) -> Fit:
    """Identify the loop behind a recording, and test whether it explains what was recorded.

    The controller by its law in OP, PV and SP; the valve by its recorded position, or by the evidence of the diagnosis
    and by how well the PV follows from it; the process by everything that explains the PV behind that valve. Then
    loops are drawn from all that is possible, and the exact limit cycle of each is set beside the swing that was
    recorded.

    Parameters
    ----------
    recording : Recording or table
        The recording, see `read` and `recording`, or a table with the columns of one loop. It must have a PV.
    loop_type : str, optional
        What the loop controls, see `loop_types`; by default what the recording says.
    sample_time : float, optional
        Time between samples of the grid, s; by default the commonest one of the recording.
    draws : int, default 60
        How many loops are drawn from what is possible, at most 10,000.
    seed : int, default 1
        Which loops are drawn.

    Returns
    -------
    Fit
        Also where a part could not be identified: `why_not` says why.

    Raises
    ------
    ValueError
        If the recording has no PV or no segment in automatic, cannot be brought onto a grid, or an option is out of
        its range.

    Notes
    -----
    It computes on its own thread without the interpreter's lock, so several can run at once. A pickled fit keeps the
    recording; after unpickling, what takes more than its attributes computes it once more.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> found = stiction.fit(stiction.recording(run.op, run.pv, run.sp, sample_time=1, name="FIC101"))
    >>> found.controller.structure, round(found.controller.kc.value, 2), round(found.controller.ti.value, 1)
    ('PI', 0.45, 6.0)
    >>> found.cycle.explained
    True
    >>> found.why_not
    {}
    """
    asked = integer("draws", draws, 1)
    if asked > 10_000:
        raise ValueError(f"draws is {asked}, but must be at most 10000")
    chosen = integer("seed", seed)
    if chosen >= 1 << 64:
        raise ValueError(f"seed is {chosen}, but must be below 2**64")
    told: dict[str, Any] = {
        "loop_type": None if loop_type is None else text("loop_type", loop_type),
        # Published methods have no part in it.
        "detectors": [],
        "sample_time": optional("sample_time", sample_time),
        "dead_time": None,
    }
    made_of = (_checked(recording, sample_time=told["sample_time"]), told, asked, chosen)
    handle = _core.fit_recording(*made_of)
    found = result_of(Fit, {"name": made_of[0].name, **handle.document()})
    # Not fields: what scenario, prospects and plot need, and what that can be made of again.
    object.__setattr__(found, "_handle", handle)
    object.__setattr__(found, "_made_of", made_of)
    return found


def _kept(fitted: Fit) -> _core.Fitted:
    """Give the handle of a fit; of one that was pickled it is computed again."""
    if "_handle" not in fitted.__dict__:
        object.__setattr__(fitted, "_handle", _core.fit_recording(*fitted.__dict__["_made_of"]))
    handle = fitted.__dict__["_handle"]
    assert isinstance(handle, _core.Fitted)
    return handle
