"""The unit for systemd and the container file start a command that exists."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from stiction.live.__main__ import parser

DEPLOY = Path(__file__).resolve().parents[3] / "deploy"


def test_the_unit_is_valid_and_starts_the_watch(tmp_path):
    text = (DEPLOY / "stiction-watch.service").read_text()
    [line] = [line for line in text.splitlines() if line.startswith("ExecStart=")]
    words = line.replace("${URL}", "opc.tcp://server:4840").split()
    assert words[1:3] == ["-m", "stiction.live"]
    known = parser().parse_args(words[3:])
    assert known.task == "watch" and known.history == 7 * 86_400
    if shutil.which("systemd-analyze") is None:
        pytest.skip("systemd is not installed")
    # The program of the unit need not be installed here.
    unit = tmp_path / "stiction-watch.service"
    unit.write_text(text.replace("/opt/stiction/bin/python", "/bin/true").replace("User=stiction\n", ""))
    done = subprocess.run(["systemd-analyze", "verify", "--man=no", str(unit)], capture_output=True, text=True, timeout=60)
    assert not [line for line in done.stderr.splitlines() if "stiction-watch" in line], done.stderr


def test_the_container_starts_the_watch():
    lines = (DEPLOY / "Containerfile").read_text().splitlines()
    [entry] = [json.loads(line.removeprefix("ENTRYPOINT ")) for line in lines if line.startswith("ENTRYPOINT ")]
    known = parser().parse_args([*entry[3:], "opc.tcp://server:4840", "--history", "7d"])
    assert entry[:3] == ["python", "-m", "stiction.live"] and known.folder == Path("/plant")
    [check] = [json.loads(line.partition(" CMD ")[2]) for line in lines if line.startswith("HEALTHCHECK ")]
    assert parser().parse_args(check[3:]).status
