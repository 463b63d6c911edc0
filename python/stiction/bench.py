"""The benchmark of detectors: any function, estimator or program measured on frozen suites of simulated loops.

A detector is a function of a recording. The function returns one of these answers:

* a number that increases with the evidence for a sticking valve;
* ``"sticks"``, ``"does not stick"`` or ``"abstain"``, or a truth value;
* a mapping with the keys ``score``, ``probability``, ``decision``, ``S`` and ``J``, all optional. S and J are numbers, or
  mappings with ``value``, ``low`` and ``high``.

If the detector raises an exception, exceeds the time limit or gives a value out of range, this counts as no answer. The results
state the reason.

Estimators of scikit-learn with ``fit`` and ``predict`` are detectors, too. Their cases are recordings.
"""

from __future__ import annotations

import copy
import json
import multiprocessing
import multiprocessing.connection
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from os import PathLike
from pathlib import Path
from types import FrameType
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from stiction import _core
from stiction._arguments import callback, integer, number, text
from stiction._core import Recording, Table
from stiction._words import documented

__all__ = ["Results", "Suite", "answer", "labelled", "method", "read", "run", "suite", "suites", "training", "verdict"]

Detector = Callable[[Recording], Any]

BATCH = 64
"""Number of loops that are simulated together while the detector answers the previous loops."""
STARTUP = 60.0
"""Additional time for the first answer of a process, s."""
STARTS = 10
"""Number of successive starts without an answer after which a process is not started again."""


class Suite(Sequence[Recording]):
    """The recordings of a suite from `suite` or `labelled`. The recordings of `suite` are simulated at each use.

    Parameters
    ----------
    name : str
        Name, one of `suites`.
    handle : object
        Loops, made by `suite`.
    """

    __slots__ = ("_handle", "name")

    def __init__(self, name: str, handle: _core.BenchSuite) -> None:
        self.name = name
        self._handle = handle

    def __len__(self) -> int:
        return len(self._handle)

    @overload
    def __getitem__(self, index: int) -> Recording: ...
    @overload
    def __getitem__(self, index: slice) -> list[Recording]: ...
    def __getitem__(self, index: int | slice) -> Recording | list[Recording]:
        where = range(len(self))[index]
        if isinstance(where, int):
            return self._handle.loops(where, where + 1)[0].recording
        return [self._handle.loops(k, k + 1)[0].recording for k in where]

    def __repr__(self) -> str:
        return f"<Suite {self.name} of {len(self)} loops>"


class Results:
    """The measures of detectors from `run` or `read`.

    Parameters
    ----------
    handle : object
        The measures.
    """

    __slots__ = ("_handle",)

    def __init__(self, handle: _core.BenchResults) -> None:
        self._handle = handle

    def table(self) -> Table:
        """Return the main measures as an Arrow table.

        Returns
        -------
        Table
            One row per detector, with 95 % intervals. ``to_pandas()`` converts the table to a DataFrame.
        """
        return self._handle.table()

    def failures(self) -> list[tuple[str, str, str]]:
        """Return the loops without an answer.

        Returns
        -------
        list of tuple
            Detector, loop and reason.
        """
        return self._handle.failures()

    def to_dict(self) -> dict[str, Any]:
        """Return all measures, comparisons and answers, as ``stiction schema bench-results`` describes them."""
        found: dict[str, Any] = json.loads(self.to_json())
        return found

    def to_json(self) -> str:
        """Return all measures, comparisons and answers as JSON, which ``stiction bench report`` and ``verify`` read."""
        return self._handle.json()

    def to_markdown(self) -> str:
        """Return the tables in Markdown."""
        return self._handle.markdown()

    def to_html(self) -> str:
        """Return one self-contained HTML page with the leaderboard, curves, differences and loops to inspect."""
        return self._handle.html()

    def save(self, path: str | PathLike[str]) -> None:
        """Write the results to a file, whole or not at all.

        Parameters
        ----------
        path : path
            The file. The name ends in ``.json``, ``.md`` or ``.html``.

        Raises
        ------
        ValueError
            If the name has a different ending.
        """
        made = {".json": self.to_json, ".md": self.to_markdown, ".html": self.to_html}
        ending = Path(path).suffix
        if ending not in made:
            raise ValueError(f"{path} must end in .json, .md or .html")
        _core.write_whole(Path(path), (made[ending]().rstrip("\n") + "\n").encode())

    def __repr__(self) -> str:
        rows = self.table()
        lines = [f"{row['detector']}: AUC {_rounded(row['auc'])}, answered {row['answered']:.0%}" for row in rows]
        return "<Results\n " + "\n ".join(lines) + ">"


def suites() -> dict[str, str]:
    """List the suites.

    Returns
    -------
    dict
        Descriptions by name.

    Examples
    --------
    >>> import stiction.bench
    >>> list(stiction.bench.suites())
    ['v1', 'v1-trial', 'v1-training']
    """
    return dict(_core.bench_suites())


def suite(name: str = "v1", *, passphrase: str | None = None) -> Suite:
    """Return the recordings of a suite, without the truth about the loops.

    Parameters
    ----------
    name : str, default "v1"
        Name, one of `suites`.
    passphrase : str, optional
        Passphrase of the hidden half of the suite. With a passphrase, the hidden half is returned. The seeds of the hidden half
        are derived from the passphrase.

    Raises
    ------
    ValueError
        If there is no such suite, the suite has no hidden half, or the passphrase is too short.

    Examples
    --------
    >>> import stiction.bench
    >>> stiction.bench.suite("v1-trial")
    <Suite v1-trial of 120 loops>
    """
    if passphrase is not None:
        text("passphrase", passphrase)
    return Suite(name, _core.bench_suite(text("name", name), passphrase))


def labelled(
    recordings: Sequence[Recording],
    sticks: npt.ArrayLike,
    *,
    valves: Sequence[str] | None = None,
    sources: Sequence[str] | None = None,
    licences: Sequence[str] | None = None,
) -> Suite:
    """Return labelled recordings of your own as a suite for `run`.

    Recordings of one valve are kept together in bootstrap draws, in the calibration, and when an estimator is cross-validated.

    Parameters
    ----------
    recordings : sequence of Recording
        The recordings. Their names must differ.
    sticks : array_like
        Whether the valves of the recordings stick, by your labels.
    valves, sources, licences : sequence of str, optional
        Valve, source and licence of each recording. By default each recording has a separate valve.

    Raises
    ------
    ValueError
        If the arguments differ in length, two names are equal, or all labels are equal.

    Examples
    --------
    >>> import stiction, stiction.bench
    >>> loops = [stiction.datasets.load(name) for name in ("FIC101-sticky", "FIC102-disturbed")]
    >>> stiction.bench.labelled(loops, [True, False])
    <Suite labelled of 2 loops>
    """
    names = [each.name for each in recordings]
    labels = np.asarray(sticks, dtype=bool).tolist()
    given = [[""] * len(names) if each is None else list(each) for each in (sources, licences)]
    columns = [names if valves is None else list(valves), *given]
    if any(len(each) != len(names) for each in [labels, *columns]):
        raise ValueError("recordings, sticks, valves, sources and licences must have equal lengths")
    if len(set(names)) < len(names):
        raise ValueError("two recordings have the same name; give each its own, with stiction.recording(..., name=...)")
    if len(set(labels)) < 2:
        raise ValueError("sticks must contain labels of both classes")
    told = [(name, valve, label, of, may) for name, label, valve, of, may in zip(names, labels, *columns)]
    return Suite("labelled", _core.bench_labelled(list(recordings), told))


def training(n: int = 2000, *, first: int = 0) -> tuple[list[Recording], npt.NDArray[np.bool_]]:
    """Return labelled loops to train a detector on. No other suite contains these loops.

    Parameters
    ----------
    n : int, default 2000
        Number of loops. Loops with masked stiction, about a quarter, are left out.
    first : int, default 0
        Number of the first loop.

    Returns
    -------
    recordings, labels
        The recordings, and whether the valves of the recordings stick.

    Raises
    ------
    ValueError
        If the suite has fewer loops.

    Examples
    --------
    >>> import stiction.bench
    >>> recordings, labels = stiction.bench.training(40)
    >>> len(recordings) == len(labels), bool(labels.any())
    (True, True)
    """
    handle = _core.bench_suite("v1-training", None)
    until = integer("first", first) + integer("n", n, 1)
    if until > len(handle):
        raise ValueError(f"first + n is {until}, but the suite v1-training has {len(handle)} loops")
    recordings, labels = [], []
    for each in (each for at in range(first, until, BATCH) for each in handle.loops(at, min(at + BATCH, until))):
        sticks = each.sticks
        if sticks is not None:
            recordings.append(each.recording)
            labels.append(sticks)
    return recordings, np.array(labels, dtype=bool)


@documented
def verdict(recording: Recording) -> dict[str, Any]:
    """Return the verdict of `diagnose` as the answer of a detector.

    Parameters
    ----------
    recording : Recording
        The recording.

    Returns
    -------
    dict
        The probability, the decision, S and J.

    Examples
    --------
    >>> import stiction.bench
    >>> loops = stiction.bench.suite("v1-trial")
    >>> sorted(stiction.bench.verdict(loops[2]))
    ['decision', 'id', 'probability']
    """
    return _own(recording, None)


class method:
    """A detector that answers with the result of one method.

    Parameters
    ----------
    name : str
        Name, see `stiction.detection.detectors`.

    Examples
    --------
    >>> import stiction.bench
    >>> loops = stiction.bench.suite("v1-trial")
    >>> "decision" in stiction.bench.method("horch")(loops[0])
    True
    """

    __slots__ = ("__name__",)

    def __init__(self, name: str) -> None:
        self.__name__ = text("name", name)

    def __call__(self, recording: Recording) -> dict[str, Any]:
        return _own(recording, self.__name__)


def _own(recording: Recording, name: str | None) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(_core.bench_answer(recording, name))
    return found


def run(
    detector: Any,
    suite: str | Suite = "v1",
    *,
    name: str | None = None,
    version: str = "",
    limit: float = 10.0,
    processes: int = 0,
    train: int = 2000,
    passphrase: str | None = None,
    progress: Callable[[int], object] | None = None,
) -> Results:
    """Measure a detector on a suite.

    Parameters
    ----------
    detector : callable, estimator or mapping
        A function of a recording, an estimator with ``fit`` and ``predict``, or several detectors by name, to compare. An
        estimator is first fitted on `training`.
    suite : str or Suite, default "v1"
        The suite, one of `suites`, or recordings from `labelled`. On labelled recordings an estimator is cross-validated in five
        parts, by valve.
    name : str, optional
        Name of the detector, shown in the results; by default the name of the function or class.
    version : str, optional
        Version of the detector, shown in the results.
    limit : float, default 10
        Time limit for an answer, s. A later answer counts as no answer. Without processes, Python code is interrupted on Unix,
        but compiled code runs to the end.
    processes : int, default 0
        Number of processes that run the detector, which must then be importable, as for `multiprocessing`. A process that exceeds
        the limit is ended. After the limit or a crash, the process is started again. 0 runs the detector in this process.
    train : int, default 2000
        Number of loops on which an estimator is fitted.
    passphrase : str, optional
        Passphrase of the hidden half of the suite. With a passphrase, the detector is measured on the hidden half.
    progress : callable, optional
        Called from time to time with the number of finished loops.

    Returns
    -------
    Results
        All measures.

    Raises
    ------
    TypeError
        If the detector is neither a function nor an estimator.
    ValueError
        If there is no such suite, or a number is out of its range.

    Examples
    --------
    >>> import numpy as np
    >>> import stiction.bench
    >>> def evenness(recording):
    ...     op = recording.op - recording.op.mean()
    ...     return -np.mean(op**4) / np.mean(op**2) ** 2 if op.any() else "abstain"
    >>> found = stiction.bench.run(evenness, "v1-trial")
    >>> found.table()["detector"], found.failures()
    (['evenness'], [])
    """
    detectors = dict(detector) if isinstance(detector, Mapping) else {name or _name(detector): detector}
    for each in detectors.values():
        if not callable(each) and not _fits(each):
            raise TypeError(
                "detector must be a function of a recording, or an estimator with fit and predict, but its type is "
                f"{type(each).__name__}"
            )
    if not detectors:
        raise ValueError("detector is an empty mapping; give at least one detector")
    within, several = number("limit", limit), integer("processes", processes)
    if not 0 < within <= 86400:
        raise ValueError(f"limit is {within}, but must be above 0 s, and at most a day")
    told = callback("progress", progress)
    if passphrase is not None:
        text("passphrase", passphrase)
    if isinstance(suite, Suite):
        called_suite, handle = suite.name, suite._handle
    else:
        called_suite, handle = suite, _core.bench_suite(text("suite", suite), passphrase)
    own = called_suite == "labelled"
    if any(_fits(each) for each in detectors.values()):
        if own:
            detectors = {called: _ByValve(each, handle) if _fits(each) else each for called, each in detectors.items()}
        else:
            X, y = training(train)
            for each in detectors.values():
                if _fits(each):
                    each.fit(X, y)
    loops: list[_core.BenchLoop] = []
    answers: dict[str, list[tuple[str, float]]] = {called: [] for called in detectors}
    workers = {called: _Processes(each, several, within) for called, each in detectors.items() if several}
    try:
        for batch in _batches(handle):
            recordings = [each.recording for each in batch]
            for called, each in detectors.items():
                found = workers[called].ask(recordings) if several else _ask(each, recordings, within)
                answers[called] += found
            loops += batch
            if told is not None:
                told(len(loops))
    finally:
        for each in workers.values():
            each.end()
    command = f"stiction.bench.run({{}}, {called_suite!r})"
    entries = [
        (called, text("version", version), command.format(_name(each)), answers[called])
        for called, each in detectors.items()
    ]
    return Results(handle.results(loops, entries))


def read(*paths: str | PathLike[str], passphrase: str | None = None) -> Results:
    """Read results of one or several detectors on the same loops, and measure the answers again.

    Parameters
    ----------
    paths : path
        Files of `Results.save` or ``stiction bench detector --json``.
    passphrase : str, optional
        Passphrase of the hidden half of the suite.

    Returns
    -------
    Results
        The measures of all detectors, with comparisons.

    Raises
    ------
    OSError
        If a file cannot be read.
    ValueError
        If a file holds no results, or the loops differ.
    """
    if passphrase is not None:
        text("passphrase", passphrase)
    texts = [(str(path), Path(path).read_text(encoding="utf-8")) for path in paths]
    return Results(_core.bench_read(texts, passphrase))


@documented
def answer(recording: Recording, said: Any) -> str:
    """Return the answer of a detector as the line of JSON that a program for ``stiction bench detector`` writes.

    Parameters
    ----------
    recording : Recording
        The recording.
    said : float, str, bool, mapping or None
        What a detector returns. None abstains.

    Raises
    ------
    TypeError
        If `said` is not an answer that a detector may give.

    Examples
    --------
    >>> import stiction.bench
    >>> stiction.bench.answer(stiction.bench.suite("v1-trial")[0], 1.5)
    '{"id": "v1-trial-00000", "score": 1.5}'
    """
    line: dict[str, Any] = {"id": recording.name}
    if said is None:
        line["decision"] = "abstain"
    elif isinstance(said, str):
        line["decision"] = said
    elif isinstance(said, (bool, np.bool_)):
        line["decision"] = "sticks" if said else "does not stick"
    elif isinstance(said, Mapping):
        line |= {key: value for key, value in said.items() if value is not None}
        line["id"] = recording.name
    else:
        try:
            line["score"] = float(said)
        except (TypeError, ValueError):
            raise TypeError(
                f"the answer must be a number, a decision, a truth value or a mapping, but its type is {type(said).__name__}"
            ) from None
    return json.dumps(line, default=_plain)


def _plain(value: Any) -> Any:
    """Return a NumPy number as a Python number."""
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"the answer holds a value of type {type(value).__name__}, which JSON cannot represent")


def _rounded(value: float | None) -> str:
    return "none" if value is None else f"{value:.3f}"


class _ByValve:
    """A detector that answers about a recording with an estimator fitted on the recordings of other valves."""

    FOLDS = 5

    def __init__(self, estimator: Any, handle: _core.BenchSuite) -> None:
        self.__name__ = _name(estimator)
        loops = handle.loops(0, len(handle))
        places = {valve: k % self.FOLDS for k, valve in enumerate(dict.fromkeys(each.valve for each in loops))}
        self.folds = {each.recording.name: places[each.valve] for each in loops}
        self.fitted = {}
        for fold in sorted(set(places.values())):
            others = [each for each in loops if places[each.valve] != fold]
            labels = np.array([bool(each.sticks) for each in others])
            self.fitted[fold] = copy.deepcopy(estimator).fit([each.recording for each in others], labels)

    def __call__(self, recording: Recording) -> Any:
        return json.loads(_predicted(self.fitted[self.folds[recording.name]], [recording])[0])


def _name(detector: Any) -> str:
    return getattr(detector, "__name__", type(detector).__name__)


def _fits(detector: Any) -> bool:
    return hasattr(detector, "fit") and hasattr(detector, "predict") and not isinstance(detector, type)


def _batches(handle: _core.BenchSuite) -> Iterator[list[_core.BenchLoop]]:
    """Yield the loops, and meanwhile simulate the next loops."""
    with ThreadPoolExecutor(1) as ahead:
        starts = range(0, len(handle), BATCH)

        def made(at: int) -> list[_core.BenchLoop]:
            return handle.loops(at, min(at + BATCH, len(handle)))

        waiting = ahead.submit(made, 0)
        for at in starts:
            batch = waiting.result()
            if at + BATCH < len(handle):
                waiting = ahead.submit(made, at + BATCH)
            yield batch


def _none(recording: Recording, reason: str) -> str:
    return json.dumps({"id": recording.name, "no_answer": reason})


def _reason(error: BaseException) -> str:
    words = str(error).strip().splitlines()
    return type(error).__name__ + (f": {words[0][:160]}" if words else "")


class _Late(BaseException):
    """Raised within a detector after the limit; handlers of `Exception` do not catch this exception."""


def _ask(detector: Any, recordings: list[Recording], limit: float) -> list[tuple[str, float]]:
    """Asks a detector about each recording separately, or an estimator about all recordings together."""
    if _fits(detector):
        return _estimated(detector, recordings, limit)
    return [_timed(lambda each=each: answer(each, detector(each)), each, limit) for each in recordings]  # type: ignore[misc]


def _timed(ask: Callable[[], str], recording: Recording, limit: float) -> tuple[str, float]:
    """Return an answer, or the reason for no answer, and the time taken."""
    begin = time.perf_counter()
    try:
        with _Alarm(limit):
            line = ask()
    except _Late:
        line = _none(recording, f"no answer within {limit:g} s")
    except Exception as error:
        line = _none(recording, _reason(error))
    spent = time.perf_counter() - begin
    # Code that no signal interrupts.
    return (line if spent <= limit else _none(recording, f"no answer within {limit:g} s")), spent


class _Alarm:
    """Raises `_Late` in this thread after a time, on systems with signals."""

    def __init__(self, limit: float) -> None:
        self.limit = limit
        main = threading.current_thread() is threading.main_thread()
        self.works = main and limit < float("inf") and hasattr(signal, "setitimer")

    def __enter__(self) -> None:
        if self.works:
            self.before = signal.signal(signal.SIGALRM, self._late)
            signal.setitimer(signal.ITIMER_REAL, self.limit)

    def __exit__(self, *_: object) -> None:
        if self.works:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, self.before)

    def _late(self, number: int, frame: FrameType | None) -> None:
        raise _Late


def _estimated(estimator: Any, recordings: list[Recording], limit: float) -> list[tuple[str, float]]:
    """Return the answers of an estimator. If a batch fails, the estimator gets the recordings one by one."""
    begin = time.perf_counter()
    try:
        with _Alarm(limit * len(recordings)):
            lines = _predicted(estimator, recordings)
        spent = (time.perf_counter() - begin) / len(recordings)
        return [(line, spent) for line in lines]
    except (_Late, Exception):
        return [_timed(lambda each=each: _predicted(estimator, [each])[0], each, limit) for each in recordings]  # type: ignore[misc]


def _predicted(estimator: Any, recordings: list[Recording]) -> list[str]:
    if hasattr(estimator, "predict_proba"):
        sticks = np.asarray(estimator.predict_proba(recordings), dtype=np.float64)[:, 1]
        said: list[Any] = [{"probability": p, "decision": "sticks" if p >= 0.5 else "does not stick"} for p in sticks.tolist()]
    elif hasattr(estimator, "decision_function"):
        scores = np.asarray(estimator.decision_function(recordings), dtype=np.float64)
        said = [{"score": s, "decision": "sticks" if s > 0 else "does not stick"} for s in scores.tolist()]
    else:
        said = [bool(each) for each in estimator.predict(recordings)]
    if len(said) != len(recordings):
        raise ValueError(f"it gave {len(said)} answers to {len(recordings)} recordings")
    return [answer(each, found) for each, found in zip(recordings, said)]


class _Processes:
    """Processes that run a detector, and are started again after a crash or the limit."""

    def __init__(self, detector: Any, count: int, limit: float) -> None:
        self.detector, self.limit = detector, limit
        self.context = multiprocessing.get_context("spawn")
        self.workers: list[_Process | None] = [None] * count
        self.vain = [0] * count

    def ask(self, recordings: list[Recording]) -> list[tuple[str, float]]:
        """Return the answers. Each process is asked about one recording at a time."""
        answers: list[tuple[str, float] | None] = [None] * len(recordings)
        waiting = list(enumerate(recordings))[::-1]
        while waiting or any(each is not None and each.asked is not None for each in self.workers):
            for at, worker in enumerate(self.workers):
                if not waiting or (worker is not None and worker.asked is not None):
                    continue
                place, recording = waiting.pop()
                if self.vain[at] >= STARTS:
                    answers[place] = (_none(recording, f"not asked, after {STARTS} starts without an answer"), 0.0)
                    continue
                if worker is None:
                    self.vain[at] += 1
                    worker = self.workers[at] = _Process(self.context, self.detector)
                worker.ask(place, recording, self.limit)
            asked = [(at, each) for at, each in enumerate(self.workers) if each is not None and each.asked is not None]
            if not asked:
                continue
            soonest = min(each.until for _, each in asked)
            multiprocessing.connection.wait(
                [each.pipe for _, each in asked], timeout=max(0.0, soonest - time.perf_counter())
            )
            for at, each in asked:
                heard = each.answer(self.limit)
                if heard is None:
                    continue
                place, line, spent, alive = heard
                answers[place] = (line, spent)
                if alive:
                    self.vain[at] = 0
                else:
                    each.end()
                    self.workers[at] = None
        return [each for each in answers if each is not None]

    def end(self) -> None:
        """End all processes."""
        for each in self.workers:
            if each is not None:
                each.end()


class _Process:
    """A process that runs a detector."""

    def __init__(self, context: Any, detector: Any) -> None:
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(detector, theirs), daemon=True)
        self.process.start()
        theirs.close()
        self.asked: tuple[int, Recording] | None = None
        self.fresh = True
        self.since = self.until = 0.0

    def ask(self, place: int, recording: Recording, limit: float) -> None:
        """Send a recording."""
        self.asked, self.since = (place, recording), time.perf_counter()
        self.until = self.since + limit + (STARTUP if self.fresh else 0)
        try:
            self.pipe.send(recording)
        except OSError:
            pass  # It has ended, which is noticed when its answer is read.

    def answer(self, limit: float) -> tuple[int, str, float, bool] | None:
        """Return place, answer, time and whether the process still runs, or None before an answer."""
        if self.asked is None:
            return None
        place, recording = self.asked
        spent = time.perf_counter() - self.since
        try:
            if self.pipe.poll():
                line, spent = self.pipe.recv()
                self.asked, self.fresh = None, False
                if spent > limit:
                    line = _none(recording, f"no answer within {limit:g} s")
                return place, line, spent, True
        except (EOFError, OSError):
            self.process.join(2)
            return place, _none(recording, f"the process ended with exit code {self.process.exitcode}"), spent, False
        if time.perf_counter() < self.until:
            return None
        return place, _none(recording, f"no answer within {limit:g} s"), spent, False

    def end(self) -> None:
        """End the process."""
        self.pipe.close()
        self.process.kill()
        self.process.join()


def _serve(detector: Any, pipe: Any) -> None:
    """Answer about recordings until no recording remains."""
    try:
        while True:
            recording = pipe.recv()
            [found] = _ask(detector, [recording], float("inf")) if _fits(detector) else [_unhurried(detector, recording)]
            pipe.send(found)
    except (EOFError, KeyboardInterrupt):
        pass


def _unhurried(detector: Detector, recording: Recording) -> tuple[str, float]:
    begin = time.perf_counter()
    try:
        line = answer(recording, detector(recording))
    except Exception as error:
        line = _none(recording, _reason(error))
    return line, time.perf_counter() - begin
