"""The bill of materials of what ships: the same from the same sources, and where a wheel has it."""

import base64
import hashlib
import importlib.util
import json
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

pytest.importorskip("tomllib")
ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "supply" / "sbom.py"


@pytest.mark.skipif(shutil.which("cargo") is None, reason="there is no Cargo")
def test_a_bill_names_what_is_linked_in_and_nothing_else():
    def made():
        command = [sys.executable, SCRIPT, "stiction-python"]
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout

    text = made()
    assert text == made() and str(ROOT) not in text
    bill = json.loads(text)
    assert (bill["bomFormat"], bill["metadata"]["component"]["name"]) == ("CycloneDX", "stiction-python")
    names = {each["name"] for each in bill["components"]}
    assert {"rayon", "parquet", "stiction-diagnose"} <= names
    # What only tests, builds or makes code is not given on.
    assert not {"proptest", "serde_derive", "clap"} & names
    assert {each["ref"] for each in bill["dependencies"]} == {
        each["bom-ref"] for each in [*bill["components"], bill["metadata"]["component"]]
    }
    foreign = [each for each in bill["components"] if not each["name"].startswith("stiction")]
    assert all(each["hashes"] and each["licenses"] for each in foreign)


def test_a_wheel_has_its_bill_and_lists_it(tmp_path):
    spec = importlib.util.spec_from_file_location("sbom", SCRIPT)
    sbom = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sbom)
    wheel = tmp_path / "x-1-py3-none-any.whl"
    with zipfile.ZipFile(wheel, "w") as file:
        file.writestr("x.py", "")
        file.writestr("x-1.dist-info/RECORD", "x.py,,0\nx-1.dist-info/RECORD,,\n")
    sbom.put(wheel, b"first")
    once = wheel.read_bytes()
    sbom.put(wheel, b"{}\n")
    sbom.put(wheel, b"first")
    assert wheel.read_bytes() == once
    with zipfile.ZipFile(wheel) as file:
        path = "x-1.dist-info/sboms/stiction.cdx.json"
        assert file.namelist() == ["x.py", path, "x-1.dist-info/RECORD"] and file.read(path) == b"first"
        digest = base64.urlsafe_b64encode(hashlib.sha256(b"first").digest()).rstrip(b"=").decode()
        rows = file.read("x-1.dist-info/RECORD").decode().splitlines()
        assert rows == ["x.py,,0", f"{path},sha256={digest},5", "x-1.dist-info/RECORD,,"]
