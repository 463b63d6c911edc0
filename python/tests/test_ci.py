"""Slow checks of CI run when what they look at has changed, and not otherwise."""

import importlib.util
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def slow():
    spec = importlib.util.spec_from_file_location("slow", ROOT / ".ci" / "slow.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def repository(tmp_path, slow, monkeypatch):
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    monkeypatch.delenv("CI_ALL", raising=False)
    subprocess.run(["git", "init", "--quiet"], cwd=tmp_path, check=True)
    (tmp_path / ".ci").mkdir()
    for name in {each for inputs in slow.CHECKS.values() for each in inputs}:
        path = tmp_path / name if Path(name).suffix else tmp_path / name / "file.txt"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(name)
    subprocess.run(["git", "add", "."], cwd=tmp_path, check=True)
    return tmp_path


def test_a_check_is_due_until_it_has_passed_and_after_every_change(slow, repository, monkeypatch):
    assert all(slow.due(repository, name) for name in slow.CHECKS)
    slow.store(repository, ["importer", "spark"])
    assert not slow.due(repository, "importer") and slow.due(repository, "notebooks")
    (repository / "python" / "tests" / "spark" / "file.txt").write_text("changed")
    assert slow.due(repository, "spark") and not slow.due(repository, "importer")
    slow.store(repository, list(slow.CHECKS))
    assert not any(slow.due(repository, name) for name in slow.CHECKS)
    # A new file counts, what git does not know does not.
    (repository / "importers" / "built").write_text("a product")
    assert not slow.due(repository, "importer")
    subprocess.run(["git", "add", "."], cwd=repository, check=True)
    assert slow.due(repository, "importer")
    slow.store(repository, ["importer"])
    (repository / "importers" / "built").unlink()
    assert slow.due(repository, "importer")
    monkeypatch.setenv("CI_ALL", "1")
    assert slow.due(repository, "notebooks")


def test_everything_is_due_where_there_is_no_repository(slow, repository, capsys):
    slow.store(repository, list(slow.CHECKS))
    shutil.rmtree(repository / ".git")
    assert all(slow.due(repository, name) for name in slow.CHECKS)
    assert "is due" in capsys.readouterr().err


def test_wrong_use_is_refused(slow, repository, capsys):
    assert slow.main(repository, ["due", "none-such"]) == slow.main(repository, []) == 2
    assert "Checks: importer" in capsys.readouterr().err
    assert slow.main(repository, ["passed", "spark"]) == 0 and slow.main(repository, ["due", "spark"]) == 1


def test_what_a_check_looks_at_exists(slow):
    for inputs in slow.CHECKS.values():
        assert all((ROOT / name).exists() for name in inputs)
