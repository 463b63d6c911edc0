"""The scripts of a release: archives have the same bytes from the same files, and trials notice differences."""

import importlib.util
import shutil
import subprocess
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


build, trial = loaded("build"), loaded("try.py")
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
