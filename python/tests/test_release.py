"""The scripts of a release: archives have the same bytes from the same files, and trials notice differences."""

import copy
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip("tomllib")
ROOT = Path(__file__).parents[2]


def loaded(name):
    loader = SourceFileLoader(name, str(ROOT / "release" / name))
    spec = importlib.util.spec_from_loader(name, loader)
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module


build, trial, promise = loaded("build"), loaded("try.py"), loaded("promise.py")
FILES = {"stiction": b"program", "man/stiction.1": b"manual", "completions/stiction.bash": b"complete", "README.md": b"read"}


def release(out):
    made = build.Release.__new__(build.Release)
    made.out, made.version = out, "1.2.3"
    made.toolchain, made.environment = SimpleNamespace(time=1_700_000_000), {"SOURCE_DATE_EPOCH": "1700000000", "PATH": "/usr/bin:/bin"}
    return made


def test_archives_depend_on_their_files_alone(tmp_path):
    sums = []
    for name in ["one", "two"]:
        out = tmp_path / name
        out.mkdir()
        made = release(out)
        made.tar(out / "a.tar.xz", "stiction-1.2.3", FILES)
        made.zip(out / "a.zip", "stiction-1.2.3", dict(reversed(FILES.items())))
        if shutil.which("dpkg-deb"):
            made.debian(build.LINUX, FILES)
        sums.append(made.sums())
        assert (out / "SHA256SUMS").read_text() == sums[-1]
    assert sums[0] == sums[1] and "a.tar.xz" in sums[0]
    with tarfile.open(tmp_path / "one/a.tar.xz") as archive:
        modes = {each.name: each.mode for each in archive}
    assert modes == {f"stiction-1.2.3/{name}": 0o755 if name == "stiction" else 0o644 for name in FILES}
    with zipfile.ZipFile(tmp_path / "one/a.zip") as archive:
        assert archive.read("stiction-1.2.3/man/stiction.1") == b"manual"


@pytest.mark.skipif(shutil.which("dpkg-deb") is None, reason="there is no dpkg-deb")
def test_the_debian_package_puts_files_where_debian_has_them(tmp_path):
    release(tmp_path).debian(build.ARM, FILES)
    package = tmp_path / "stiction_1.2.3_arm64.deb"
    listed = subprocess.run(["dpkg-deb", "--contents", package], check=True, capture_output=True, text=True).stdout
    for path in ["usr/bin/stiction", "usr/share/man/man1/stiction.1.gz", "usr/share/bash-completion/completions/stiction"]:
        assert f"./{path}" in listed
    told = subprocess.run(["dpkg-deb", "--field", package, "Version", "Architecture"], check=True, capture_output=True, text=True)
    assert told.stdout == "Version: 1.2.3\nArchitecture: arm64\n"


@pytest.mark.parametrize(
    ("own", "other", "found"),
    [
        ("S 4.1 %", "S 4.1 %", 0.0),
        ("S 4.1 %", "J 4.1 %", None),
        ("S 4.1 %", "S 4.1 % (4 to 5)", None),
        ('{"S": 2.0}', '{"S": 2.5}', 0.2),
        ('{"x": 1e-17}', '{"x": -3e-17}', 4e-11),
    ],
)
def test_a_trial_tells_words_from_digits(own, other, found):
    assert trial.difference(own, other) == pytest.approx(found)


OLD = {
    "properties": {"S": {"$ref": "#/$defs/Estimate"}, "loops": {"type": "array", "items": {"$ref": "#/$defs/Estimate"}}},
    "required": ["S"],
    "$defs": {"Estimate": {"type": "object", "properties": {"value": {"type": "number"}}, "required": ["value"]}},
}


@pytest.mark.parametrize(
    ("change", "broken"),
    [
        (lambda new: None, []),
        (lambda new: new["properties"].update(J={"type": "number"}), []),
        (lambda new: new["required"].append("loops"), []),
        (lambda new: new["properties"].pop("loops"), ["d: loops is gone", "d: loops[].value is gone"]),
        (lambda new: new.update(required=[]), ["d: S may be missing now"]),
        (
            lambda new: new["$defs"]["Estimate"]["properties"].update(value={"type": ["number", "null"]}),
            ["d: S.value may be null now", "d: loops[].value may be null now"],
        ),
    ],
)
def test_keys_that_go_or_change_break_the_promise(change, broken):
    new = copy.deepcopy(OLD)
    change(new)
    assert list(promise.broken_keys("d", OLD, new)) == broken


def test_a_key_of_several_variants_has_the_types_of_all():
    variant = lambda kind: {"type": "object", "properties": {"at": {"type": kind}}, "required": ["at"]}
    both = {"anyOf": [variant("number"), variant("string")]}
    assert list(promise.broken_keys("d", both, {"anyOf": [variant("string")]})) == []
    assert list(promise.broken_keys("d", {"anyOf": [variant("string")]}, both)) == ["d: at may be number now"]
    free = {"anyOf": [variant("number"), {"properties": {"at": {"type": "string"}}}]}
    assert list(promise.broken_keys("d", both, free)) == ["d: at may be missing now"]


def test_a_program_without_documents_is_not_taken_for_one_that_breaks_nothing(tmp_path):
    program = tmp_path / "stiction"
    program.write_text("#!/bin/sh\necho nothing\n")
    program.chmod(0o755)
    with pytest.raises(SystemExit, match="the documents are not listed"):
        promise.schemas(program)


@pytest.mark.parametrize(
    ("now", "broken"),
    [
        ([["a", "POSITIONAL_OR_KEYWORD", False], ["b", "KEYWORD_ONLY", True]], []),
        ([["a", "POSITIONAL_OR_KEYWORD", True], ["b", "KEYWORD_ONLY", True], ["c", "KEYWORD_ONLY", True]], []),
        ([["a", "POSITIONAL_OR_KEYWORD", False]], ["f: the parameter b is gone"]),
        ([["a", "KEYWORD_ONLY", False], ["b", "KEYWORD_ONLY", True]], ["f: the parameter a must be named now"]),
        ([["a", "POSITIONAL_OR_KEYWORD", False], ["b", "KEYWORD_ONLY", False]], ["f: the parameter b must be given now"]),
        (
            [["c", "POSITIONAL_OR_KEYWORD", False], ["a", "POSITIONAL_OR_KEYWORD", False], ["b", "KEYWORD_ONLY", True]],
            ["f: parameters are in another order", "f: the new parameter c must be given"],
        ),
    ],
)
def test_parameters_that_go_or_change_break_the_promise(now, broken):
    before = [["a", "POSITIONAL_OR_KEYWORD", False], ["b", "KEYWORD_ONLY", True]]
    assert list(promise.broken_calls({"f": before}, {"f": now})) == broken
    assert list(promise.broken_calls({"f": before}, {})) == ["f is gone"]


def test_a_name_may_leave_the_top_for_its_module():
    old = dict.fromkeys(["stiction.fit", "stiction.Stem.follow", "stiction.stem.Stem.follow", "stiction.fitting.fit"])
    new = dict.fromkeys(["stiction.stem.Stem.follow", "stiction.fitting.prospects"])
    assert list(promise.broken_calls(old, new)) == ["stiction.fit is gone", "stiction.fitting.fit is gone"]


def test_a_promise_covers_the_names_of_the_package():
    found = json.loads(promise.printed(sys.executable, promise.SIGNATURES))
    assert {"stiction.diagnose", "stiction.valve_test.read", "stiction.fmu.export"} <= found.keys()
    assert ["recording", "POSITIONAL_OR_KEYWORD", False] in found["stiction.valve_test.read"]


@pytest.mark.skipif("STICTION_PROGRAM" not in os.environ, reason="STICTION_PROGRAM is not given")
def test_a_promise_covers_the_documents_and_options_of_the_program():
    program = Path(os.environ["STICTION_PROGRAM"])
    found = promise.schemas(program)
    assert promise.keys(found["diagnosis"])
    assert {"diagnose --json", "plant scan --since", "test read"} <= promise.options(program)
