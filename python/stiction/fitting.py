"""The fitted loop of a recording (controller, process and valve), whether the valve explains the swing, and which action would stop
the swing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stiction import _core, _plots
from stiction._arguments import choice, integer, optional, text
from stiction._core import Recording, Scenario
from stiction._document import (
    Estimate,
    FittedController,
    FittedCycle,
    FittedProcess,
    FittedValve,
    OperatingPoint,
    PredictedSwing,
    Proposal,
    Prospect,
    RankedProspects,
    RecordedSwing,
)
from stiction._result import Result, about, result, result_of
from stiction._words import drawn
from stiction.closed_loop import simulate
from stiction.compensation import compensators
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
class Prospects(RankedProspects):
    """The actions for a recorded loop."""

    def _summary(self) -> list[str]:
        best = self.actions[0]
        return [
            f"Prospects of {len(self.actions)} actions, from {self.loops} loops that agree with the recording",
            f"best: {best.action}, PV swing {best.pv_swing.value:.2g} PV units ({best.pv_swing.low:.2g} to"
            f" {best.pv_swing.high:.2g})",
        ]

    @drawn(2)
    def plot(self, ax: Any = None) -> Any:
        """Draw the swing of the PV and the control error for every action, with intervals."""
        made = _plots.axes(ax, 2, sharex=False, height=max(2.0, 0.33 * len(self.actions)))
        names = [row.action for row in self.actions]
        quantities = (
            ("swing of the PV (PV units)", [row.pv_swing for row in self.actions]),
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
    """The prediction for an action, and the result of the action."""

    action: str = about("The action, as in `Prospect`.")
    before: float
    after: float = about("Swing of the PV before and after the action, in PV units.")
    predicted: Estimate = about("The prediction for the swing after the action.")
    as_predicted: bool = about("Whether the result is within the predicted interval, or better.")
    sentence: str = about("The comparison in words.")


@result
class Fit(Result):
    """The fitted loop of a recording. Parts that could not be identified are None, with the reason in `why_not`."""

    name: str = about("Tag of the loop.")
    sample_time_s: float = about("Time between the samples of the fit, s.")
    resting: OperatingPoint = about("The operating point of the loop.")
    controller: FittedController | None = about("The controller.")
    process: FittedProcess | None = about("The process behind the valve.")
    valve: FittedValve | None = about("The valve.")
    cycle: FittedCycle | None = about("The limit cycle of the fitted loop, compared with the recorded swing.")
    why_not: dict[str, str] = about(
        "Why a part could not be identified, by the name of the part; empty if all parts were identified.",
        kind="dict of str",
    )

    @classmethod
    def _prepared(cls, document: Mapping[str, Any]) -> Mapping[str, Any]:
        # In documents a part has its values, or the reason why it is not identified.
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
        """The signals of the fit, on a regular grid."""
        return Segment(**_kept(self).segment())

    def scenario(self) -> Scenario:
        """Return the loop as a scenario, with the most likely values.

        Returns
        -------
        Scenario
            For `simulate`, `limit_cycle`, `compensate`, `what_if`, `stiction.fmu.export` and other functions that take a
            scenario. The ``text`` of the scenario is TOML with the source of each value.

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
        """Simulate the effects of actions on loops drawn from all loops that agree with the recording.

        Returns
        -------
        Prospects
            The loop without changes, and the loop after each action: repair, retuning, both, a positioner, and compensators that
            an ordinary controller can implement.

        Raises
        ------
        ValueError
            If a part of the loop is not identified, or most of the possible valves follow the OP.

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
        """Compare the prediction for an action with a recording after the action.

        Parameters
        ----------
        after : Recording
            A recording of the same loop after the action.
        action : str, default "repair"
            The action: ``"nothing"``, ``"repair"``, ``"retune"``, ``"repair-and-retune"``, ``"positioner"``, or the name of a
            compensator, see `stiction.compensation.compensators`.

        Raises
        ------
        ValueError
            If no prediction for the action exists, the loop did not oscillate before the action, or a recording has no PV for a
            whole period of the oscillation; also for a reason given in `prospects`.

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
        """Draw recorded PV and OP above the simulated signals of the fitted loop, on equal scales.

        The figure shows at most 1,200 samples from the middle of the recording, and as many from the end of the simulation.

        Raises
        ------
        ValueError
            For a reason given in `scenario`.
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
        # The handle is made again from the recording when needed.
        return {key: value for key, value in self.__dict__.items() if key != "_handle"}


def fit(
    recording: RecordingLike,
    *,
    loop_type: str | None = None,
    sample_time: float | None = None,
    draws: int = 60,
    seed: int = 1,
) -> Fit:
    """Identify the loop of a recording, and test whether the valve explains the recorded swing.

    The controller is identified from OP, PV and SP. The valve is identified from the recorded valve position, or from the
    evidence of the diagnosis and the prediction of the PV. With this valve, the fit keeps all processes that explain the PV
    nearly as well as the best process. Then possible loops are drawn from these results, and the exact limit cycle of each loop
    is compared with the recorded swing.

    Parameters
    ----------
    recording : Recording or table
        The recording, see `stiction.read` and `stiction.recording`, or a table with the columns of one loop. The recording must
        have a PV.
    loop_type : str, optional
        Type of the loop, see `stiction.recordings.loop_types`; by default as in the recording.
    sample_time : float, optional
        Time between samples of the grid, s; by default the most frequent sample time of the recording.
    draws : int, default 60
        Number of loops drawn from the possible loops, at most 10,000.
    seed : int, default 1
        Seed of the drawn loops.

    Returns
    -------
    Fit
        A fit is also returned if a part could not be identified, with the reason in `why_not`.

    Raises
    ------
    ValueError
        If the recording has no PV or no segment in automatic, does not fit on a grid, or an option is out of its range.

    Notes
    -----
    The computation runs on a separate thread without the interpreter's lock, so several fits can run at once. A pickled
    fit keeps the recording. After unpickling, functions that need more than the attributes compute the fit again.

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
        # Published methods are not needed.
        "detectors": [],
        "sample_time": optional("sample_time", sample_time),
        "dead_time": None,
    }
    made_of = (_checked(recording, sample_time=told["sample_time"]), told, asked, chosen)
    handle = _core.fit_recording(*made_of)
    found = result_of(Fit, {"name": made_of[0].name, **handle.document()})
    # Not fields, but the data for scenario, prospects and plot, and for making them again.
    object.__setattr__(found, "_handle", handle)
    object.__setattr__(found, "_made_of", made_of)
    return found


def _kept(fitted: Fit) -> _core.Fitted:
    """Return the handle of a fit, computed again for a pickled fit."""
    if "_handle" not in fitted.__dict__:
        object.__setattr__(fitted, "_handle", _core.fit_recording(*fitted.__dict__["_made_of"]))
    handle = fitted.__dict__["_handle"]
    assert isinstance(handle, _core.Fitted)
    return handle
