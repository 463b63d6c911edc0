"""HTML for notebooks: cards, trends and tables, in the colours of a light or dark page.

The HTML loads nothing from elsewhere, the styles apply only to this HTML, and every text is escaped.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from stiction._arrays import Array

__all__: list[str] = []

_WIDTH, _LEFT, _RIGHT = 640, 64, 8
_ROW, _GAP = 96, 26
_SHOWN = 20
# Each colour has a contrast of at least three to both white and black pages.
_COLOURS = {"PV": "#2e9455", "SP": "currentColor", "OP": "#3f87d0", "VP": "#d9534f"}

Line = tuple[str, Array]
"""The name and the values of a signal."""


def card(title: str, headline: str, facts: Mapping[str, str], first: str, picture: str) -> str:
    """Return a card with the conclusion in large letters, facts below it, the first action, and a picture."""
    cells = "".join(
        f'<div style="margin-right:2em"><div style="opacity:.75;font-size:.85em">{escape(name)}</div>{escape(fact)}</div>'
        for name, fact in facts.items()
    )
    advice = f'<p style="margin:.6em 0"><b>First:</b> {escape(first[0].upper() + first[1:])}</p>' if first else ""
    return (
        '<div style="font:14px/1.45 system-ui,sans-serif;max-width:680px;padding:.8em 1em;border-radius:6px;'
        'border:1px solid rgba(128,128,128,.6)">'
        f'<div style="opacity:.75">{escape(title)}</div>'
        f'<div style="font-size:1.4em;font-weight:600;margin-bottom:.3em">{escape(headline)}</div>'
        f'<div style="display:flex;flex-wrap:wrap">{cells}</div>{advice}{picture}</div>'
    )


def trend(label: str, time_s: Array, rows: Sequence[tuple[str, Sequence[Line]]], since: str = "") -> str:
    """Return an SVG picture of rows of signals, one above the other, over the same time.

    A row has signals, and an axis label with a unit. `since` is the text for time zero.
    """
    unit, seconds = _time_unit(float(time_s[-1] - time_s[0]))
    t = time_s / seconds
    x = _scale(float(t[0]), float(t[-1]), _LEFT, _WIDTH - _RIGHT)
    parts = []
    for place, (axis, lines) in enumerate(rows):
        top = 18 + place * (_ROW + _GAP)
        parts.append(_panel(axis, lines, t, x, top))
    foot = 18 + len(rows) * (_ROW + _GAP) - _GAP
    for tick in _ticks(float(t[0]), float(t[-1]), 6):
        parts.append(_text(x(tick), foot + 15, f"{tick:g}", "middle"))
    parts.append(_text((_LEFT + _WIDTH - _RIGHT) / 2, foot + 31, f"time ({unit}){since}", "middle"))
    return (
        f'<svg role="img" aria-label="{escape(label)}" viewBox="0 0 {_WIDTH} {foot + 36}" '
        'style="width:100%;max-width:640px;height:auto;display:block" font-size="11" font-family="system-ui,sans-serif" '
        f'fill="currentColor" xmlns="http://www.w3.org/2000/svg">{"".join(parts)}</svg>'
    )


def table(columns: Mapping[str, Sequence[Any]]) -> str:
    """Return columns as an HTML table, with only the first rows of a long table."""
    rows = list(zip(*columns.values()))
    head = "".join(f'<th scope="col" style="text-align:{_side(held)}">{escape(name)}</th>' for name, held in columns.items())
    sides = [_side(held) for held in columns.values()]
    body = "".join("<tr>" + "".join(map(_cell, row, sides)) + "</tr>" for row in rows[:_SHOWN])
    more = f"<p>{len(rows) - _SHOWN} more rows</p>" if len(rows) > _SHOWN else ""
    return (
        f'<div style="overflow-x:auto"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}</div>'
    )


def _side(column: Sequence[Any]) -> str:
    """Return the alignment of a column, right for numbers."""
    return "right" if any(isinstance(value, (int, float)) and not isinstance(value, bool) for value in column) else "left"


def _cell(value: Any, side: str) -> str:
    shown = "" if value is None else f"{value:.4g}" if isinstance(value, float) else escape(str(value))
    return f'<td style="text-align:{side}">{shown}</td>'


def _panel(axis: str, lines: Sequence[Line], t: Array, x: Any, top: float) -> str:
    """Draw the signals of one row between two lines at the smallest and the largest tick."""
    values = np.concatenate([signal for _, signal in lines])
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    if high - low < 1e-9 * max(abs(low), abs(high), 1e-300):
        low, high = low - 0.5, high + 0.5
    y = _scale(low, high, top + _ROW, top)
    parts = [_text(_LEFT, top - 6, axis, "start")]
    for tick in _ticks(low, high, 4):
        at = y(tick)
        parts.append(
            f'<line x1="{_LEFT}" x2="{_WIDTH - _RIGHT}" y1="{at:.1f}" y2="{at:.1f}" stroke="currentColor" '
            'stroke-opacity=".2"/>'
        )
        parts.append(_text(_LEFT - 6, at + 4, f"{tick:g}", "end"))
    right = float(_WIDTH - _RIGHT)
    for name, signal in reversed(lines):
        dash = ' stroke-dasharray="5 3"' if name == "SP" else ""
        points = " ".join(f"{x(a):.1f},{y(b):.1f}" for a, b in _thinned(t, signal))
        parts.append(
            f'<polyline points="{points}" fill="none" stroke="{_COLOURS[name]}" stroke-width="1.3"{dash}/>'
        )
        parts.append(
            f'<text x="{right:.1f}" y="{top - 6:.1f}" text-anchor="end" style="fill:{_COLOURS[name]}">'
            f"{'- - ' if dash else '&#8212; '}{escape(name)}</text>"
        )
        right -= 48
    return "".join(parts)


def _thinned(t: Array, signal: Array, most: int = 600) -> list[tuple[float, float]]:
    """Return the points of a line in order, with the smallest and the largest value for every pixel."""
    finite = np.isfinite(signal)
    t, signal = t[finite], signal[finite]
    if len(signal) > 2 * most:
        edges = np.linspace(0, len(signal), most + 1).astype(int)
        kept = {0, len(signal) - 1}
        for begin, end in zip(edges[:-1], edges[1:]):
            kept |= {int(begin + signal[begin:end].argmin()), int(begin + signal[begin:end].argmax())}
        places = sorted(kept)
        t, signal = t[places], signal[places]
    return list(zip(t.tolist(), signal.tolist()))


def _scale(low: float, high: float, first: float, last: float) -> Any:
    """Map numbers to coordinates."""
    return lambda value: first + (value - low) / ((high - low) or 1.0) * (last - first)


def _ticks(low: float, high: float, about: int) -> list[float]:
    """Return round numbers between two numbers, about as many as `about`."""
    if not high > low:
        return [low]
    rough = (high - low) / about
    size = 10.0 ** math.floor(math.log10(rough))
    step = size * next(factor for factor in (1, 2, 5, 10) if factor * size >= rough * (1 - 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [float(f"{k * step:.10g}") for k in range(first, last + 1)]


def _time_unit(span_s: float) -> tuple[str, float]:
    """Return the unit for a duration, and the length of the unit in seconds."""
    for unit, seconds in (("d", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if span_s >= 3 * seconds:
            return unit, seconds
    return "s", 1.0


def _text(x: float, y: float, words: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill-opacity=".85">{escape(words)}</text>'
