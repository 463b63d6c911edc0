"""A played plant, for the tests of live data. All servers listen on 127.0.0.1 only."""

import sys
from pathlib import Path

import pytest
import stiction.plant

sys.path.insert(0, str(Path(__file__).parent))

from processes import HERE, Process, free_port

pytest.importorskip("pyarrow")


@pytest.fixture
def run():
    started = []

    def begin(*arguments, **more):
        started.append(Process(*arguments, **more))
        return started[-1]

    yield begin
    for each in started:
        each.end(kill=True)


@pytest.fixture(scope="session")
def plant(tmp_path_factory):
    """A day of six loops."""
    folder = tmp_path_factory.mktemp("played")
    stiction.plant.demo(folder, loops=6, days=1)
    return folder


@pytest.fixture
def watched(plant, tmp_path):
    """The folder of a plant that a watch fills."""
    folder = tmp_path / "watched"
    folder.mkdir()
    (folder / "plant.toml").write_text((plant / "plant.toml").read_text().replace("data/*", "data/**/*"))
    return folder


class Live:
    """A server that plays a plant, and a watch of it."""

    def __init__(self, run, plant, watched):
        self.run, self.plant, self.watched, self.port = run, plant, watched, free_port()
        self.url = f"opc.tcp://127.0.0.1:{self.port}"

    def serve(self, *arguments):
        server = self.run(HERE / "server.py", "--plant", self.plant, "--port", self.port, *arguments)
        server.info = server.answer("listening")
        return server

    def watch(self, *arguments, url=None, **more):
        fast = ["--publish", "100ms", "--sample", "0s"]
        return self.run("-m", "stiction.live", "watch", url or self.url, "-C", self.watched, *fast, *arguments, **more)


@pytest.fixture
def live(run, plant, watched):
    pytest.importorskip("asyncua")
    return Live(run, plant, watched)
