"""Functional mock-up units (FMU): sticking valves, stems and loops for Simulink, OpenModelica, Dymola and FMPy.

Call the functions with the name of the module, as in ``stiction.fmu.export(...)``.
"""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from datetime import datetime
from os import PathLike
from pathlib import Path
from typing import Literal

from stiction import _core
from stiction._arguments import integer, number, text
from stiction._document import FmuModel, FmuVariable
from stiction._result import result_of
from stiction.closed_loop import ScenarioLike, scenario

__all__ = ["FmuModel", "FmuVariable", "export", "models", "variables"]


def models() -> list[FmuModel]:
    """List the models that can be exported.

    Examples
    --------
    >>> import stiction
    >>> [model.name for model in stiction.fmu.models() if model.kind == "stem"][:4]
    ['classical', 'karnopp', 'dahl', 'lugre']
    """
    return [result_of(FmuModel, model) for model in _core.fmu_models()]


def variables(
    model: str | None = None,
    *,
    S: float | None = None,
    J: float | None = None,
    stem: str | None = None,
    loop: ScenarioLike | None = None,
    start: Mapping[str, float | bool] | None = None,
) -> list[FmuVariable]:
    """List the variables of an FMU.

    Parameters
    ----------
    model, S, J, stem, loop, start
        The content of the FMU, as for `export`.

    Raises
    ------
    ValueError
        If there is no such model or variable, or values do not fit together.

    Examples
    --------
    >>> import stiction
    >>> [v.name for v in stiction.fmu.variables("two-phase") if v.role in ("input", "output")]
    ['OP', 'VP', 'stuck', 'slips']
    """
    return [FmuVariable(**variable) for variable in _fmu(model, S, J, stem, loop, start).variables()]


def export(
    path: str | PathLike[str],
    model: str | None = None,
    *,
    S: float | None = None,
    J: float | None = None,
    stem: str | None = None,
    loop: ScenarioLike | None = None,
    start: Mapping[str, float | bool] | None = None,
    fmi: Literal[2, 3] = 2,
    libraries: Mapping[str, str | PathLike[str]] | None = None,
    date: datetime | None = None,
) -> Path:
    """Write a valve, a stem or a whole loop as a functional mock-up unit. Neither the export nor the import of the unit needs a
    compiler.

    Parameters
    ----------
    path : str or path
        The file to write, such as ``"valve.fmu"``.
    model : str, optional
        A valve model, see `stiction.valves.valve_models`; by default ``"two-phase"``, unless `stem` or `loop` is given.
    S, J : float, optional
        Stick band plus dead band, and slip jump, of the valve model, percent of span.
    stem : str, optional
        A friction law or parameter set of a physical stem, instead of a valve model; see `stiction.stem.stem_sets`.
    loop : scenario, str, path or mapping, optional
        A closed loop, instead of a valve model, as for `stiction.scenario`.
    start : mapping, optional
        Start values of variables by name, such as ``{"stem_lag": 0.5}``; `variables` lists them.
    fmi : {2, 3}, default 2
        Version of FMI. Both versions support co-simulation, and for stems also model exchange.
    libraries : mapping, optional
        Compiled libraries of additional platforms, such as ``{"x86_64-windows": "stiction_fmu.dll"}``. A library for a built-in
        platform replaces the built-in library.
    date : datetime, optional
        Time of generation in the model description; by default the time in the environment variable ``SOURCE_DATE_EPOCH``, s since
        1970, or now. Equal model and date give equal bytes. A time without a zone is local.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    TypeError
        If more than one of `model`, `stem` and `loop` is given, or an argument has the wrong type.
    ValueError
        If there is no such model or variable, or values do not fit together.

    Examples
    --------
    >>> import os, tempfile, stiction
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = stiction.fmu.export(os.path.join(folder, "valve.fmu"), "two-phase", S=5, J=3)
    ...     path.stat().st_size > 100_000
    True
    """
    fmu = _fmu(model, S, J, stem, loop, start)
    more = []
    for platform, library in (libraries or {}).items():
        arch, dash, system = text("libraries", platform).partition("-")
        if not dash:
            raise ValueError(
                f"libraries names the platform {platform!r}, but its keys must be like 'x86_64-windows'"
            )
        more.append((arch, system, Path(library).read_bytes()))
    path = Path(path)
    _core.write_whole(path, fmu.bytes(integer("fmi", fmi), more, _generated_s(date)))
    return path


def _generated_s(date: datetime | None) -> int:
    """Return the time of generation of an FMU, s since 1970."""
    if date is None:
        epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
        if epoch and not epoch.isdecimal():
            raise ValueError(f"SOURCE_DATE_EPOCH is {epoch!r}, but must be a whole number of seconds")
        return int(epoch or time.time())
    if not isinstance(date, datetime):
        raise TypeError(f"date must be a datetime, but its type is {type(date).__name__}")
    seconds = int(date.timestamp())
    if seconds < 0:
        raise ValueError(f"date is {date}, but must be after 1970")
    return seconds


def _fmu(
    model: str | None,
    S: float | None,
    J: float | None,
    stem: str | None,
    loop: ScenarioLike | None,
    start: Mapping[str, float | bool] | None,
) -> _core.Fmu:
    """Return the model to export."""
    if sum(given is not None for given in (model, stem, loop)) > 1:
        raise TypeError("give only one of model, stem and loop")
    if start is not None and not isinstance(start, Mapping):
        raise TypeError(f"start must be a mapping, but its type is {type(start).__name__}")
    bands = {name: value for name, value in (("S", S), ("J", J)) if value is not None}
    if bands and stem is not None:
        raise TypeError("S and J belong to a valve model; a stem has friction instead")
    values = [(text("start", name), number(name, value)) for name, value in {**bands, **(start or {})}.items()]
    if loop is not None:
        return _core.Fmu("loop", "", values, scenario(loop))
    if stem is not None:
        return _core.Fmu("stem", text("stem", stem), values)
    return _core.Fmu("valve", text("model", model or "two-phase"), values)
