"""Shared functions of all plots. Matplotlib is imported only when a plot is requested."""

from __future__ import annotations

from typing import Any

from stiction._arrays import Array
from stiction._dates import moments

__all__: list[str] = []


def pyplot() -> Any:
    """Return ``matplotlib.pyplot``, or raise an error that explains how to install Matplotlib."""
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise ImportError("plots need Matplotlib: pip install stiction[plot]") from None
    return plt


def legend_above(ax: Any) -> None:
    """Put the legend above the axes, in the middle."""
    columns = max(1, len(ax.get_legend_handles_labels()[0]))
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=columns, frameon=False, fontsize="small")


def axes(ax: Any, rows: int = 1, *, sharex: bool = True, height: float = 2.2) -> list[Any]:
    """Return `rows` axes above each other: the given axes `ax` (one, or a sequence of axes), or new axes."""
    if ax is None:
        plt = pyplot()
        size = (8.0, max(3.5, height * rows))
        _, made = plt.subplots(rows, 1, sharex=sharex, figsize=size, squeeze=False, layout="constrained")
        return list(made[:, 0])
    given = list(ax) if hasattr(ax, "__len__") else [ax]
    if len(given) != rows:
        raise ValueError(f"ax holds {len(given)} axes, but {rows} are needed")
    return given


def dates(start: float | None, time_s: Array) -> tuple[Any, str]:
    """Return the times to plot and the label of the time axis: dates if the start of the clock is known, else seconds."""
    return (time_s, "time (s)") if start is None else (moments(start, time_s), "time (UTC)")


def short_dates(ax: Any) -> None:
    """Label dates on the x axis without repeating the common part of the dates."""
    from matplotlib.dates import ConciseDateFormatter

    formatter: Any = ConciseDateFormatter
    ax.xaxis.set_major_formatter(formatter(ax.xaxis.get_major_locator()))


def legend(ax: Any) -> None:
    """Put the legend above the axes, on the right, because titles are on the left."""
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, frameon=False, borderaxespad=0.1)


def valve_over_time(ax: Any, time_s: Any, op: Any, vp: Any, label: str = "OP, VP (% of span)") -> None:
    """Plot the VP, and the OP unless the OP is None."""
    ax.plot(time_s, vp, color="C3", label="VP")
    if op is not None:
        ax.plot(time_s, op, color="C0", linestyle="--", linewidth=1.2, label="OP")
    ax.set_xlabel("time (s)")
    ax.set_ylabel(label)
    legend(ax)


def pv_over_time(ax: Any, time_s: Any, sp: Any, pv: Any, label: str = "PV, SP (PV units)") -> None:
    """Plot the SP unless the SP is None, and the PV unless the PV is None."""
    if pv is not None:
        ax.plot(time_s, pv, color="C2", label="PV")
    if sp is not None:
        ax.plot(time_s, sp, color="k", linestyle="--", linewidth=1.0, label="SP")
    ax.set_ylabel(label)
    legend(ax)
