"""The server of node-opcua plays a plant and a watch records it, for the tests and for ``python/benchmarks/live.py``."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import stiction.plant
from processes import HERE, Process
from server import played
from stiction.live import hours


class Node(Process):
    program = "node"


def node_modules(folder):
    """The folder with the server and its packages, or why there is none. STICTION_NODE_MODULES names a folder that has them."""
    if shutil.which("node") is None or shutil.which("npm") is None:
        return None, "node is not installed"
    folder = Path(os.environ.get("STICTION_NODE_MODULES") or folder)
    for name in ("package.json", "server.js"):
        shutil.copy(HERE / "node" / name, folder / name)
    if not (folder / "node_modules" / "node-opcua").is_dir():
        words = ["npm", "install", "--no-fund", "--no-audit", "--ignore-scripts"]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=300)
        if done.returncode != 0:
            return None, f"node-opcua could not be installed: {done.stderr[-200:]}"
    return folder, ""


def of_plant(plant, seconds, modes=False):
    """The times and values of each tag in the first seconds of a plant, with a mode for each loop if asked for."""
    data = played(plant, None)
    begin = min(int(times[0]) for times, _ in data.values())
    data = {tag: (times[times < begin + 1e6 * seconds], values[times < begin + 1e6 * seconds]) for tag, (times, values) in data.items()}
    if modes:
        for tag, (times, _) in list(data.items()):
            if tag.endswith(".OP"):
                data.setdefault(tag.removesuffix("OP") + "MODE", (times, np.ones(len(times))))
    return {tag: own for tag, own in data.items() if len(own[0])}


def node_server(modules, port, folder, data, speed, *more):
    """A server of node-opcua that plays data."""
    file = folder / "played.json"
    file.write_text(json.dumps({tag: list(zip((times // 1000).tolist(), values.tolist())) for tag, (times, values) in data.items()}))
    return Node(modules / "server.js", port, file, speed, folder / "keys", *more)


def recorded(folder, held=False):
    """The good values of each tag."""
    found = {}
    for path in sorted((folder / "data").glob("*/*.parquet")):
        for tag, rows in hours.tables_by_tag(path):
            own = (rows.status < hours.BAD) if held else (rows.status == 0)
            found.setdefault(tag, []).extend(zip(rows.time[own].tolist(), rows.value[own].tolist()))
    return found


def unequal(watched, data):
    """The tags whose recorded values are not those of the data."""
    found = recorded(watched)
    expected = {tag: list(zip(times.tolist(), values.tolist())) for tag, (times, values) in data.items()}
    return sorted(tag for tag in found.keys() | expected.keys() if found.get(tag, []) != expected.get(tag, []))


def judged_otherwise(watched, data, folder):
    """The columns in which the windows of a watch differ from those of a scan of the same data in one file."""
    folder.mkdir()
    (folder / "plant.toml").write_text((watched / "plant.toml").read_text())
    tables = [hours.table_of(tag, hours.Rows(*own, np.zeros(len(own[0]), np.uint32))) for tag, own in sorted(data.items())]
    hours.written(folder / "data" / "all.parquet", iter(tables))
    stiction.plant.scan(folder)
    expected, found = (stiction.plant.windows(each).to_dict() for each in (folder, watched))
    assert any(len(column) for column in expected.values())
    return [name for name in expected if not name.endswith("_fingerprint") and found[name] != expected[name]]
