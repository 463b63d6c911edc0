"""A watch of a second server, of node-opcua: what is recorded is what was played."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

pytest.importorskip("asyncua")

from processes import HERE, Process, wait_for
from stiction.live import hours, opcua
from test_watch import of_plant, recorded, state

FOLDER = HERE / "node"


@pytest.fixture(scope="module")
def modules(tmp_path_factory):
    """The server's packages; STICTION_NODE_MODULES names a folder that has them."""
    if shutil.which("node") is None or shutil.which("npm") is None:
        pytest.skip("node is not installed")
    folder = Path(os.environ.get("STICTION_NODE_MODULES") or tmp_path_factory.mktemp("node"))
    for name in ("package.json", "server.js"):
        shutil.copy(FOLDER / name, folder / name)
    if not (folder / "node_modules" / "node-opcua").is_dir():
        words = ["npm", "install", "--no-fund", "--no-audit", "--ignore-scripts"]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=300)
        if done.returncode != 0:
            pytest.skip(f"node-opcua could not be installed: {done.stderr[-200:]}")
    return folder


class Node(Process):
    program = "node"


@pytest.mark.parametrize("encrypted", [False, True], ids=["open", "encrypted"])
def test_what_is_recorded_was_played(modules, live, tmp_path, encrypted):
    begin = 1_772_409_600_000_000
    data = of_plant(live.plant, begin, begin + 600_000_000)
    (tmp_path / "played.json").write_text(json.dumps({tag: [[t // 1000, v] for t, v in own] for tag, own in data.items() if own}))
    server = Node(modules / "server.js", live.port, tmp_path / "played.json", 50, tmp_path / "keys")
    try:
        server.answer("listening", 60)
        if encrypted:
            made = live.run("-m", "stiction.live", "watch", "--make-certificate", "-C", live.watched)
            assert made.process.wait(30) == 0
        watch = live.watch(*(["--trust-first"] if encrypted else ["--security", "none"]))
        watch.says("connected to", 60)
        server.tell("play")
        # It samples every 50 ms at most, so a value must last longer than that.
        wait_for(lambda: (state(live).get("known_until") or 0) > 1e-6 * begin + 600, 60, "the end")
        server.tell("requests")
        asked = server.answer("requests")["requests"]
        assert watch.end() == 0
    finally:
        server.end(kill=True)
    hours.Recorder(live.watched, []).release(1 << 62)
    hours.fold(live.watched, live.watched / "data")
    assert recorded(live.watched) == {tag: own for tag, own in data.items() if own}
    assert asked["PublishRequest"] > 1 and set(asked) <= {kind.__name__ for kind in opcua.SERVICES}
    assert any("is trusted from now on" in line for line in watch.log) == encrypted
