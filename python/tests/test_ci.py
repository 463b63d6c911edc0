"""The scripts of CI: slow checks run when their inputs have changed, budgets of the build hold, and prose follows the style."""

import importlib.util
import json
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def script(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / ".ci" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def slow():
    return script("slow")


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


def committed(repository, budgets, message):
    (repository / ".ci").mkdir(exist_ok=True)
    (repository / ".ci" / "budget.json").write_text(json.dumps(budgets))
    who = ["-c", "user.name=A", "-c", "user.email=a@example.org"]
    subprocess.run(["git", "add", ".ci"], cwd=repository, check=True)
    subprocess.run(["git", *who, "commit", "--quiet", "-m", message], cwd=repository, check=True)


def test_a_budget_is_raised_only_by_a_commit_that_says_why(tmp_path):
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    budget = script("budget")
    subprocess.run(["git", "init", "--quiet"], cwd=tmp_path, check=True)
    assert budget.unexplained(tmp_path) == []
    committed(tmp_path, {"command": {"crates": 10, "own lines": 100}}, "First")
    committed(tmp_path, {"command": {"crates": 9, "own lines": 100}}, "Fewer crates")
    assert budget.unexplained(tmp_path) == []
    committed(tmp_path, {"command": {"crates": 9, "own lines": 120}}, "A feature")
    assert budget.unexplained(tmp_path) == ["command: own lines from 100 to 120"]
    # A later reason is for what it raises itself.
    committed(tmp_path, {"command": {"crates": 9, "own lines": 130}}, "A feature\n\nBudget: it needs ten lines.")
    assert budget.unexplained(tmp_path) == ["command: own lines from 100 to 120"]


def test_a_budget_may_be_raised_for_a_reason(tmp_path):
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    budget = script("budget")
    subprocess.run(["git", "init", "--quiet"], cwd=tmp_path, check=True)
    committed(tmp_path, {"command": {"crates": 9}}, "First")
    committed(tmp_path, {"command": {"crates": 12}}, "A feature\n\nBudget: it needs three crates.")
    assert budget.unexplained(tmp_path) == []


def test_lines_are_those_that_a_build_may_read(tmp_path):
    for name, text in {"src/lib.rs": "a\nb\n", "src/deep/c.rs": "c\n", "tests/t.rs": "t\n", "build.rs": "d\n", "src/e.txt": "e\n"}.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    assert script("budget").lines(tmp_path) == 4


def test_what_ships_is_optimised_where_a_light_build_is_not():
    tomllib = pytest.importorskip("tomllib")
    profiles = tomllib.loads((ROOT / "Cargo.toml").read_text())["profile"]
    light = {name for name, of in profiles["release"]["package"].items() if of.get("opt-level", 3) < 3}
    assert light and light <= {name for name, of in profiles["dist"]["package"].items() if of.get("opt-level") in (3, "s")}


@pytest.fixture
def prose():
    return script("prose")


@pytest.mark.parametrize(
    ("sentence", "habit"),
    [
        ("The test does not tell.", "tell"),
        ("What speaks for sticking is listed.", "speaks for"),
        ("A plant file that is there is kept.", "that is there"),
        ("The loop: its valve: it sticks.", "two colons"),
        ("One; two; three; four.", "three semicolons"),
    ],
)
def test_a_habit_is_found(prose, sentence, habit):
    (fault,) = prose.faults(sentence)
    assert habit in fault


def test_plain_sentences_and_citations_pass(prose):
    for sentence in (
        "The program cannot tell whether the valve sticks.",
        "Put the controller in manual. Wait until the PV is calm.",
        "K. Astrom: Automatica 20 (1984) 645: recalled; not read; cited; here.",
    ):
        assert list(prose.faults(sentence)) == []


@pytest.mark.parametrize(
    ("name", "is_test"),
    [
        ("crates/stiction-cli/src/bench/planned_tests.rs", False),
        ("crates/stiction-cli/src/valve_test.rs", False),
        ("addons/stiction-plant/src/store/tests.rs", True),
        ("python/tests/test_ci.py", True),
    ],
)
def test_tests_are_no_prose(prose, name, is_test):
    assert bool(prose.LEFT_OUT.search(name)) == is_test


def test_each_language_is_read_with_the_line_of_its_text(prose):
    assert list(prose.markdown("# A\n\nOne two\nthree.\n\n```sh\nnot this\n```\n")) == [(1, "# A"), (3, "One two three.")]
    rust = '/// A doc\n/// comment.\nfn f() { g("a string", \'"\'); } // no\n#[cfg(test)]\nmod tests { "not this" }'
    assert list(prose.rust(rust)) == [(3, "a string"), (1, "A doc comment.")]
    assert list(prose.python('def f():\n    """Give it."""\n    return "a b"\n')) == [(2, "Give it."), (3, "a b")]
    assert list(prose.rust('const POLICY: &str = "default-src none; img-src self";')) == []
    assert list(prose.python('run("() => { document.title = 1; go(); }")')) == []
    assert list(prose.pages('<p>Some plain text</p>\n<i title="a title">')) == [(1, "Some plain text"), (2, "a title")]


@pytest.fixture
def claims():
    return script("claims")


def test_a_figure_needs_a_source(claims):
    page = "# A\n\nIt finds 47 of 100 valves. The interval is a 90 % interval.\n\n| a | b |\n|---|---|\n| c | 5 % |\n"
    faults = list(claims.unsourced("a.md", page, []))
    assert [fault.split(":")[1] for fault in faults] == ["3", "7"]
    assert list(claims.unsourced("a.md", page, [{"says": "finds 47 of 100"}, {"says": "| a | b |"}])) == []
    [gone] = claims.unsourced("a.md", "Nothing.", [{"says": "finds 47 of 100"}])
    assert "is not there" in gone
    assert list(claims.commandless("a.md", "# A\n\n## B\n\nIt takes 5 s.\n")) != []
    assert list(claims.commandless("a.md", "# A\n\n## B\n\nIt takes 5 s.\n\n```sh\nstiction bench\n```\n")) == []


def test_a_figure_in_a_help_needs_a_source(claims, tmp_path):
    program = tmp_path / "program"
    helps = {
        "--help": "It helps.\n\nCommands:\n  find  Find\n  help  Print\n\nOptions:",
        "find": "Finds 47 of 100.\n\n  --n <N>  Number [default: 3]\n\n  --m <M>\n\n  [default: 4]\n\nExamples:\n  find 5 %\n",
    }
    program.write_text("#!/bin/sh\ncase $1 in\n" + "".join(f"{name}) echo '{text}';;\n" for name, text in helps.items()) + "esac\n")
    program.chmod(0o755)
    text = claims.help_of(str(program))
    assert [fault.split(": ", 2)[2] for fault in claims.unsourced("--help", text, [])] == ["Finds 47 of 100.", "--n <N> Number [default: 3]"]
    assert list(claims.unsourced("--help", text, [{"says": "47 of 100"}, {"says": "[default: 3]"}])) == []


def test_a_figure_in_the_prose_of_a_card_needs_a_source(claims):
    for card in claims.CARDS:
        faults = list(claims.unsourced(card, claims.text_of(card), []))
        assert faults and not any(": | " in fault for fault in faults)


def test_a_source_that_says_otherwise_is_reported(claims):
    def why(program=None, **claim):
        return claims.contradicted("a.md", {"says": "x", **claim}, program)

    assert why(file="README.md", has="# stiction") is None
    assert "lacks" in why(file="README.md", has="not in it")
    assert "lacks" in why(file="no.md", has="a")
    assert why(measured="2026-11-29, commit 4cc20762") is None and why(given=True) is None
    assert "needs" in why(measured="lately") and "needs" in why()
    assert why("/bin/echo", run="stiction a 5 % b", prints="a ... b") is None
    assert "prints no" in why("/bin/echo", run="stiction 5 %", prints="6 %")
