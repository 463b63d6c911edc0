"""Live data of a plant: OPC UA servers, SQL databases and PI, all of them only read.

``python -m stiction.live watch opc.tcp://server:4840 -C north`` collects and judges a plant day and night, and ``stiction watch`` is
the same. The extra ``stiction[live]`` has what it needs. ``docs/live.md`` describes it.
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
    """Copy samples from a database to files of days in a plant, for `stiction.plant.scan`. It only reads from the database.

    Parameters
    ----------
    folder : path
        The folder of ``plant.toml``.
    url : str
        The database: ``postgres://reader@host/plant``, ``odbc://DSN=plant``, or ``pi://host/piwebapi/SERVER``.
    table : str, optional
        The table, unless the address ends with ``?table=NAME``.
    since : str, optional
        The first day to read, such as ``"2026-03-01"``; by default what is new since the last call, and the two days before.

    Returns
    -------
    dict
        The numbers of ``days``, ``rows`` and ``loops``.

    Warns
    -----
    UserWarning
        About rows with wrong times, and about values that differ from those of an earlier call.

    Raises
    ------
    Refused
        If the address, the table or ``plant.toml`` is wrong; the message states the remedy.
    """
    from stiction.live import sql

    return sql.fetch(url, Path(folder), table=table, since=since, note=lambda text: warnings.warn(text, stacklevel=2))
