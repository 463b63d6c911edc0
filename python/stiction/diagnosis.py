"""Diagnosis of a recording, with verdict and evidence, and the combination of several diagnoses of one valve."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from datetime import datetime, timedelta
from os import PathLike
from pathlib import Path
from typing import Any

from stiction import _core, _document, _html, _plots
from stiction._arguments import number, optional, text
from stiction._arrays import Samples
from stiction._core import Recording, Table
from stiction._document import *
from stiction._document import Contrast, Drift, Estimate, Found, History, Observation, RepairEffect, ValveChange
from stiction._result import Result, about, result, result_of
from stiction._words import documented, drawn
from stiction.detection import MethodEvidence, _evidence
from stiction.recordings import RecordingLike, Segment, _checked, _is_table
from stiction.recordings import recording as _recording

__all__ = [
    "Contrast",
    "Diagnosis",
    "Drift",
    "History",
    "Observation",
    "RepairEffect",
    "Weighing",
    "combine",
    "diagnose",
    "diagnose_all",
    "document",
    "repair_effect",
    "report",
    "summary_table",
]
__all__ += _document.__all__


@result
class Weighing(Result):
    """The weighed evidence."""

    probability: float = about("The probability that the valve sticks or does not respond.")
    lines: dict[str, float] = about("The probability from each line of evidence alone.")
    causes: dict[str, float] = about("The probability of every cause. The probabilities add up to one.")
    S: Estimate = about("S if the valve sticks, percent of span, with a 90 % interval of any width.")
    J_over_S: Estimate = about("J over S if the valve sticks, with a 90 % interval of any width.")
    limit: float | None = about(
        "Detection limit of S, percent of span (95 %); None if stiction of any size could have been missed."
    )
    z: float = about(
        "How much better a sticking valve predicts the PV than a valve that follows the OP, in standard errors; from 3 "
        "on, a valve is not cleared."
    )
    op_range: float = about("Widest range of the OP in a window, percent of span.")
    distance: float = about(
        "Distance of the recording from the training loops; above 1 the recording is not judged."
    )
    strangest: list[str] = about("The features that lie farthest outside the range of the training loops.")
    changes: list[ValveChange] = about(
        "The changes of the valve within the recording. Windows before the valve last began or ceased to stick do not count."
    )
    features: dict[str, float] = about(
        "The numbers of the most typical window by name, see `stiction.fusion.evidence_features`; NaN where not measured."
    )


@result
class Diagnosis(Found):
    """The complete diagnosis of one loop."""

    evidence: Weighing | None = about("The weighed evidence; None without evidence.")
    oscillating_signal: str | None = about("The signal in which the oscillation was found.", kind='{"error", "OP"} or None')
    rank: float = about("The rank of the loop in a list, lowest for the worst loop.")

    @property
    def segment(self) -> Segment | None:
        """The judged signals on a regular grid; None without a segment in automatic."""
        found = _kept(self).segment()
        return None if found is None else Segment(**found)

    @property
    def start_time(self) -> datetime | None:
        """Time zero of the recording's clock in UTC; None if unknown."""
        start_time: datetime | None = self.__dict__["_made_of"][0].start_time
        return start_time

    @property
    def observation(self) -> Observation | None:
        """The observation of the valve at the middle of the segment; the time is in s since 1970 if the start is known."""
        seen = _kept(self).observation()
        return None if seen is None else result_of(Observation, seen)

    @documented
    def method_evidence(self, method: str) -> MethodEvidence | None:
        """Return the arrays from which a method decides on the segment.

        Returns
        -------
        MethodEvidence or None
            None if the method cannot be applied.

        Raises
        ------
        ValueError
            If there is no such method.
        """
        return _evidence(_kept(self).method_evidence(text("method", method)))

    def to_dict(self) -> dict[str, Any]:
        """Return the diagnosis as the document that ``stiction diagnose --json`` prints."""
        return document([self])

    def _summary(self) -> list[str]:
        facts = _facts(self)
        sizes = ", ".join(f"{name} {facts.pop(name)}" for name in ("S", "J") if name in facts)
        rest = [f"{name}: {fact}" for name, fact in facts.items()]
        return [f"Diagnosis of {self.name} ({self.loop_type}): {_headline(self)}", *([sizes] if sizes else []), *rest]

    def _repr_html_(self) -> str:
        return _html.card(
            f"{self.name} ({self.loop_type})", _headline(self), _facts(self), _first_step(self), _trend(self)
        )

    def to_html(self) -> str:
        """Return the report as one self-contained HTML page."""
        return report([self])

    def save_report(self, path: str | PathLike[str]) -> None:
        """Write the report to a file.

        Parameters
        ----------
        path : str or path
            The file, usually ``.html``. An existing file is replaced after the whole report is written.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        _core.write_whole(Path(path), self.to_html().encode())

    @drawn(3)
    def plot(self, ax: Any = None) -> Any:
        """Draw PV and SP over time, OP over time, and PV over OP.

        Raises
        ------
        ValueError
            If there is no segment to draw.
        """
        segment = self.segment
        if segment is None:
            raise ValueError(f"loop {self.name} has no segment in automatic to draw")
        made = _plots.axes(ax, 3, sharex=False, height=3.0)
        above, middle, below = made
        start = self.__dict__["_made_of"][0].start
        time, label = _plots.dates(start, segment.time_s)
        if segment.pv is not None:
            above.plot(time, segment.pv, label="PV")
            if segment.sp is not None:
                above.plot(time, segment.sp, "--", label="SP")
            below.plot(segment.op, segment.pv, linewidth=0.8, label="PV")
        middle.plot(time, segment.op, color="C2", label="OP")
        if segment.vp is not None:
            middle.plot(time, segment.vp, color="C3", label="VP")
            if segment.pv is None:
                below.plot(segment.op, segment.vp, linewidth=0.8, label="VP")
        says = "" if self.verdict.probability is None else f", {100 * self.verdict.probability:.1f} %"
        above.set_title(f"{self.name}: {self.verdict.grade}{says}")
        above.set(xlabel=label, ylabel="PV (its units)")
        middle.set(xlabel=label, ylabel="OP (% of span)")
        for each in (above, middle):
            if start is not None and each.lines:
                _plots.short_dates(each)
        below.set(xlabel="OP (% of span)", ylabel="PV (its units)" if segment.pv is not None else "VP (% of span)")
        for each in made:
            if each.get_legend_handles_labels()[0]:
                each.legend(loc="upper right")
        return made

    def __getstate__(self) -> dict[str, Any]:
        # The handle is made again from the recording when needed.
        return {key: value for key, value in self.__dict__.items() if key != "_handle"}


def diagnose(
    recording: RecordingLike,
    pv: Samples | None = None,
    sp: Samples | None = None,
    vp: Samples | None = None,
    *,
    loop_type: str | None = None,
    detectors: str | Sequence[str] = "all",
    sample_time: float | None = None,
    dead_time: float | None = None,
) -> Diagnosis:
    """Diagnose a recording.

    Parameters
    ----------
    recording : Recording, table or array_like
        The recording, see `stiction.read`, or a table with the columns of one loop, see `stiction.recording_from`. With `pv` or
        `vp`, `recording` is the controller output, percent of span.
    pv, sp : array_like, optional
        Process value and set point, in PV units, together with the controller output.
    vp : array_like, optional
        Measured valve position, percent of span, together with the controller output.
    loop_type : str, optional
        Type of the loop, see `stiction.recordings.loop_types`; by default as in the recording.
    detectors : {"all", "none"} or sequence of str, default "all"
        The methods to run. The methods take most of the time. Methods that use a measured valve position are always run.
    sample_time : float, optional
        Time between samples of the grid, s; by default the most frequent sample time of the recording. For arrays, and tables
        without times, `sample_time` is the time between samples.
    dead_time : float, optional
        Dead time of process and valve together, s, for the Harris index.

    Returns
    -------
    Diagnosis
        A diagnosis is also returned if the data cannot answer, with the reason.

    Raises
    ------
    TypeError
        If `recording` is no recording, table or array.
    ValueError
        If a table or arrays cannot be read as a recording, the recording does not fit on a grid, or an option is out of its
        range.

    Notes
    -----
    The computation runs on a separate thread without the interpreter's lock, so several diagnoses can run at once. A
    pickled diagnosis keeps the recording. After unpickling, report, plot and table compute the diagnosis again.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> loop = stiction.recording(run.op, run.pv, run.sp, sample_time=1, name="FIC101")
    >>> found = stiction.diagnose(loop, detectors="none")
    >>> found.verdict.class_
    'sticks'
    >>> found.stiction.S.low < 4 < found.stiction.S.high
    True

    With arrays instead of a recording:

    >>> stiction.diagnose(run.op, run.pv, run.sp, sample_time=1, detectors="none").verdict.class_
    'sticks'
    """
    signals = {name: signal for name, signal in (("pv", pv), ("sp", sp), ("vp", vp)) if signal is not None}
    if signals:
        if isinstance(recording, Recording) or _is_table(recording):
            kind = type(recording).__name__
            raise TypeError(f"{next(iter(signals))} is given with a {kind}, which has its own signals")
        if sample_time is None:
            raise ValueError("sample_time must be given with arrays; if the arrays have times, diagnose a stiction.recording")
        made = _recording(recording, **signals, sample_time=sample_time)
    else:
        made = _checked(recording, sample_time=sample_time)
    [diagnosis] = diagnose_all(
        [made],
        loop_type=loop_type,
        detectors=detectors,
        sample_time=sample_time,
        dead_time=dead_time,
    )
    return diagnosis


def diagnose_all(
    recordings: Iterable[RecordingLike],
    *,
    loop_type: str | None = None,
    detectors: str | Sequence[str] = "all",
    sample_time: float | None = None,
    dead_time: float | None = None,
    progress: Callable[[int], object] | None = None,
) -> list[Diagnosis]:
    """Diagnose recordings on all processors.

    Parameters
    ----------
    recordings : iterable of Recording or table
        The recordings, or tables with the columns of one loop each.
    loop_type, detectors, sample_time, dead_time : optional
        As in `diagnose`.
    progress : callable, optional
        Called with the number of finished recordings after each increase.

    Returns
    -------
    list of Diagnosis
        The diagnoses in the order of the recordings.

    Raises
    ------
    ValueError
        If a recording does not fit on a grid, or an option is out of its range.
    """
    if _is_table(recordings):
        splits = "stiction.recordings.recordings_from splits it"
        raise TypeError(f"recordings must be a list, but is one table; {splits}")
    checked = [_checked(each, f"recordings[{place}]", sample_time) for place, each in enumerate(recordings)]
    if isinstance(detectors, str) and detectors not in {"all", "none"}:
        raise ValueError(f"detectors is {detectors!r}, but must be 'all', 'none' or a sequence of names")
    if callable(detectors) or (not isinstance(detectors, str) and any(map(callable, detectors))):
        raise TypeError("detectors must be names of methods; stiction.bench.run measures a function of your own")
    asked = {"all": None, "none": []}[detectors] if isinstance(detectors, str) else list(detectors)
    told = {
        "loop_type": None if loop_type is None else text("loop_type", loop_type),
        "detectors": asked if asked is None else [text("detectors", name) for name in asked],
        "sample_time": optional("sample_time", sample_time),
        "dead_time": optional("dead_time", dead_time),
    }
    handles = _core.diagnose_recordings(checked, told, progress)
    return [_diagnosis(*each, told) for each in zip(handles, checked)]


@documented
def document(diagnoses: Iterable[Diagnosis]) -> dict[str, Any]:
    """Return diagnoses as the document that ``stiction diagnose --json`` prints."""
    found: dict[str, Any] = _core.diagnoses_document(_all_kept(diagnoses))
    return found


@documented
def report(diagnoses: Iterable[Diagnosis]) -> str:
    """Return the report on diagnoses as one self-contained HTML page, the worst loop first."""
    return _core.diagnoses_html(_all_kept(diagnoses))


@documented
def summary_table(diagnoses: Iterable[Diagnosis]) -> Table:
    """Return diagnoses as a table with one row per loop.

    Returns
    -------
    Table
        The columns have the names of ``stiction diagnose --csv``.
    """
    return _core.diagnoses_table(_all_kept(diagnoses))


def combine(observations: Iterable[Diagnosis | Observation]) -> History:
    """Combine observations of one valve, in any order. Only observations since the valve last began or ceased to stick count.

    Parameters
    ----------
    observations : iterable of Diagnosis or Observation
        Observations of the valve. Diagnoses without a judged segment are left out.

    Raises
    ------
    ValueError
        If a time or an S is not finite, a probability not between 0 and 1, or a weight below 0.

    Examples
    --------
    >>> import stiction
    >>> seen = [stiction.diagnosis.Observation(time_s=t, class_="sticks", probability=0.95) for t in range(5)]
    >>> stiction.diagnosis.combine(seen).class_
    'sticks'
    """
    return result_of(History, _core.observations_combined(_seen(observations)))


def repair_effect(observations: Iterable[Diagnosis | Observation], time_s: float) -> RepairEffect:
    """Compare observations of one valve before and after a repair.

    Parameters
    ----------
    observations : iterable of Diagnosis or Observation
        Observations of the valve, in any order.
    time_s : float
        Time of the repair, s on the clock of the observations.

    Raises
    ------
    ValueError
        If the time is not finite, or for a reason given in `combine`.
    """
    return result_of(RepairEffect, _core.observations_repair(_seen(observations), number("time_s", time_s)))


def _percent(share: float) -> str:
    """Return a probability as in reports, such as "more than 99 %"."""
    if share > 0.99:
        return "more than 99 %"
    if 0.79 < share < 0.8:
        return "79 %"  # A valve "probably sticks" from 80 % on.
    return "less than 1 %" if share < 0.01 else f"{100 * share:.0f} %"


def _headline(diagnosis: Diagnosis) -> str:
    verdict = diagnosis.verdict
    if verdict.probability is None or verdict.grade == _CANNOT_ANSWER:
        return verdict.grade
    return f"{verdict.grade} (probability of sticking: {_percent(verdict.probability)})"


def _facts(diagnosis: Diagnosis) -> dict[str, str]:
    """Return the facts of a diagnosis at a prompt, besides the verdict."""
    facts = {}
    for name in ("S", "J"):
        found = getattr(diagnosis.stiction, name)
        if found is not None:
            facts[name] = f"{_rough(found.value)} % of span ({_rough(found.low)} to {_rough(found.high)})"
        elif diagnosis.verdict.class_ == "sticks":
            facts[name] = "not quantified"
    limit = diagnosis.verdict.S_below
    if "S" not in facts and limit is not None:
        facts["S"] = f"below {_rough(limit.value)} % of span"
    swing = diagnosis.oscillation
    if swing is not None:
        every = "" if swing.period_s is None else f"every {float(f'{swing.period_s:.3g}'):g} s"
        facts["swing"] = every or "found" if swing.found else "none found"
    if diagnosis.evidence is not None and diagnosis.evidence.changes:
        last = diagnosis.evidence.changes[-1]
        facts["last change"] = f"{last.change}, at about {float(f'{last.time_s:.3g}'):g} s"
    if diagnosis.verdict.alternatives:
        other = diagnosis.verdict.alternatives[0]
        facts["likeliest other cause"] = f"{other.cause} ({_percent(other.likelihood)})"
    return facts


_TESTED = {"sticks", "probably sticks", "unclear"}
_CANNOT_ANSWER = "data cannot answer"
_WORTH_RULING_OUT = 0.2
"""Likelihood from which another cause is pursued before stiction."""


def _rough(value: float) -> str:
    """Return a number with two digits."""
    return f"{float(f'{value:.2g}'):g}"


def _first_step(diagnosis: Diagnosis) -> str:
    """Return the first action: improve the data, step the OP, test the valve, or look for a different cause, in this order."""
    verdict = diagnosis.verdict
    if diagnosis.relation is not None:
        return diagnosis.relation.remedy
    if diagnosis.few_slips is not None:
        return diagnosis.few_slips.words
    if verdict.grade == _CANNOT_ANSWER:
        return diagnosis.fitness.reasons[0] if diagnosis.fitness.reasons else ""
    if verdict.confirm is not None and verdict.grade in _TESTED:
        return f"Test the valve: {verdict.confirm.summary}."
    if diagnosis.no_response is not None and diagnosis.no_response.faults:
        return diagnosis.no_response.faults[0].told_by
    other = verdict.alternatives[0] if verdict.alternatives else None
    least = max(_WORTH_RULING_OUT, verdict.probability or 0.0)
    if other is None or other.cause == "normal operation" or other.likelihood < least:
        return ""
    return other.because


def _trend(diagnosis: Diagnosis) -> str:
    """Return a picture of PV and SP above the OP and, if measured, the VP."""
    segment = diagnosis.segment
    if segment is None:
        return ""
    recording = diagnosis.__dict__["_made_of"][0]
    above = [(name, signal) for name, signal in (("PV", segment.pv), ("SP", segment.sp)) if signal is not None]
    below = [(name, signal) for name, signal in (("OP", segment.op), ("VP", segment.vp)) if signal is not None]
    unit = recording.pv_unit or "its units"
    rows = [(f"{' and '.join(name for name, _ in above)} ({unit})", above)] if above else []
    rows.append((f"{' and '.join(name for name, _ in below)} (% of span)", below))
    start, clock = diagnosis.start_time, diagnosis.plant_time
    shown = start and start + timedelta(seconds=clock.offset_s)
    since = f" since {shown:%Y-%m-%d %H:%M:%S} {clock.name}".rstrip() if shown else ""
    label = f"Trend of {diagnosis.name}: {', '.join(axis for axis, _ in rows)} over time{since}"
    return _html.trend(label, segment.time_s, rows, since)


def _diagnosis(handle: _core.Diagnosed, recording: Recording, told: dict[str, Any]) -> Diagnosis:
    found = handle.document()
    oscillation = found["oscillation"]
    found["oscillating_signal"] = None if oscillation is None else oscillation.pop("signal")
    # More was weighed than documents show.
    found["evidence"], found["rank"] = handle.weighing(), handle.rank()
    diagnosis = result_of(Diagnosis, found)
    # Not fields, but the data for report, plot and table, and for making them again.
    object.__setattr__(diagnosis, "_handle", handle)
    object.__setattr__(diagnosis, "_made_of", (recording, told))
    return diagnosis


def _kept(diagnosis: Diagnosis) -> _core.Diagnosed:
    """Return the handle of a diagnosis, computed again for a pickled diagnosis."""
    if not isinstance(diagnosis, Diagnosis):
        raise TypeError(f"diagnoses must contain only Diagnosis objects, but one item is a {type(diagnosis).__name__}")
    if "_handle" not in diagnosis.__dict__:
        recording, told = diagnosis.__dict__["_made_of"]
        [handle] = _core.diagnose_recordings([recording], told, None)
        object.__setattr__(diagnosis, "_handle", handle)
    handle = diagnosis.__dict__["_handle"]
    assert isinstance(handle, _core.Diagnosed)
    return handle


def _all_kept(diagnoses: Iterable[Diagnosis]) -> list[_core.Diagnosed]:
    if isinstance(diagnoses, Diagnosis):
        raise TypeError("diagnoses must be a list of diagnoses, not a single one")
    return [_kept(each) for each in diagnoses]


def _seen(observations: Iterable[Diagnosis | Observation]) -> list[Any]:
    if isinstance(observations, (Diagnosis, Observation)):
        raise TypeError("observations must be a list, but is a single one")
    seen = []
    for each in observations:
        observation = each.observation if isinstance(each, Diagnosis) else each
        if observation is None:
            continue
        if not isinstance(observation, Observation):
            raise TypeError(
                f"observations must contain only Diagnosis or Observation objects, but one item is a {type(each).__name__}"
            )
        s, j = observation.S, observation.J
        seen.append(
            (
                number("time_s", observation.time_s),
                text("class_", observation.class_),
                None if observation.grade is None else text("grade", observation.grade),
                optional("probability", observation.probability),
                None if s is None else (s.value, s.low, s.high),
                None if j is None else (j.value, j.low, j.high),
                number("weight", observation.weight),
                number("windows", observation.windows),
                None if observation.pool is None else text("pool", observation.pool),
            )
        )
    return seen
