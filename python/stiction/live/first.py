"""Proposes a first ``plant.toml`` from a server or a database."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

import stiction.plant
from stiction import _core
from stiction.live import hours
from stiction.live.errors import Refused
from stiction.live.words import counted

__all__: list[str] = []


def of_samples(plant: Path, samples: Callable[[Path], None], *, force: bool = False) -> tuple[int, int]:
    """Propose ``plant.toml`` from samples that `samples` writes to a path, and return the numbers of loops and doubts."""
    path = plant / "plant.toml"
    if path.exists() and not force:
        raise Refused(f"{path} exists already; --force overwrites it")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "data").mkdir()
        samples(Path(folder) / "data" / "sample.parquet")
        try:
            text, doubts = stiction.plant.propose(folder, ["data"], name=plant.resolve().name or "plant")
        except ValueError as error:
            raise Refused(str(error)) from None
    plant.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return len(re.findall(r"^\[loop\.", text, re.MULTILINE)), len(doubts)


async def of_server(plant: Path, url: str, security: object, say: Callable[[str], None], *, force: bool = False) -> str:
    """Propose ``plant.toml`` from the variables of an OPC UA server, and list their nodes in ``live.toml``."""
    from stiction.live import opcua, tags

    if (plant / "plant.toml").exists() and not force:
        raise Refused(f"{plant / 'plant.toml'} exists already; --force overwrites it")
    assert isinstance(security, opcua.Security)
    server = opcua.Server(url, security, say=say)
    try:
        await server.connect()
    except Refused:
        raise
    except Exception as error:
        raise Refused(f"no connection to {url}: {error or type(error).__name__}; check the address and the server") from None
    try:
        file = _core.Plant('name = "new"', "the server")
        found = await tags.of_server(file, server, say)
        if not found:
            raise Refused(f"no variable of {url} has the name of a loop's tag; write plant.toml and {tags.NAME} by hand")
        now = await server.clock()
        nodes = {k: node for k, name in enumerate(found) if (node := server.node_of(found[name])) is not None}
        values = await server.read(nodes)
    finally:
        await server.close()

    def samples(path: Path) -> None:
        def rows(k: int) -> hours.Rows:
            content = values[k].Value.Value if k in values and values[k].Value is not None else None
            number = float(content) if isinstance(content, (int, float)) else np.nan
            # One value shows no sample time, and none is needed.
            return hours.Rows(np.array([now - 1_000_000, now]), np.array([number] * 2), np.array([hours.GOOD] * 2, np.uint32))

        hours.written(path, (hours.table_of(name, rows(k)) for k, name in enumerate(found)))

    loops, doubts = of_samples(plant, samples, force=force)
    (plant / tags.NAME).write_text(tags.text_of(found, url), encoding="utf-8")
    return f"{counted(loops, 'loop')}, {counted(doubts, 'doubt')}; see {plant / 'plant.toml'} and {plant / tags.NAME}"
