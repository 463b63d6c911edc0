"""Live data of a plant from OPC UA servers, SQL databases and PI, which are only read.

``stiction watch opc.tcp://server:4840 -C north`` collects and judges the data of a plant day and night.
``python -m stiction.live watch`` is a longer form of ``stiction watch``. Both commands need the extra ``stiction[live]``.
``docs/live.md`` describes both commands.
"""

from __future__ import annotations

import os
import warnings
from pathlib import Path

from stiction.live.errors import Refused

__all__ = ["Refused", "fetch"]


def fetch(
    folder: str | os.PathLike[str], url: str, *, table: str | None = None, since: str | None = None
) -> dict[str, int]:
    """Copy samples from a database to daily files in a plant, for `stiction.plant.scan`. The database is only read.

    Parameters
    ----------
    folder : path
        The folder of ``plant.toml``.
    url : str
        The database: ``postgres://reader@host/plant``, ``odbc://DSN=plant``, or ``pi://host/piwebapi/SERVER``.
    table : str, optional
        The table, unless the address ends with ``?table=NAME``.
    since : str, optional
        The first day to read, such as ``"2026-03-01"``; by default two days before the last day of the previous call.

    Returns
    -------
    dict
        The numbers of ``days``, ``rows`` and ``loops``.

    Warns
    -----
    UserWarning
        About rows with wrong times, and about values that differ from the values of an earlier call.

    Raises
    ------
    Refused
        If the address, the table or ``plant.toml`` is wrong. The message states the remedy.
    """
    from stiction.live import sql

    return sql.fetch(url, Path(folder), table=table, since=since, note=lambda text: warnings.warn(text, stacklevel=2))
