"""Checks what must be compiled before a new user sees anything, against what we allow (`.ci/budget.json`).

    python3 .ci/budget.py    # exit code 1: above the budget, or a budget was raised without a reason

The README's first command compiles the command `stiction`, `pip install .` the Python module. Of each, the check counts the
crates and the lines of their Rust sources, ours and those of others. A commit that raises a budget says why in a line of its message that begins with
"Budget:".
"""

import json
import subprocess
import sys
from pathlib import Path

# What may not be raised without a reason: this one, and that of instructions.py.
BUDGETS = (".ci/budget.json", ".ci/instructions.json")
# What is built, and the package that it is.
BUILT = {"command": "stiction-cli", "wheel": "stiction-python"}
# Folders of a package that a build leaves alone.
LEFT_OUT = {"tests", "benches", "examples", "fuzz", "target", "docs"}


def output_of(*command: str, root: Path) -> str:
    """What a program prints."""
    return subprocess.run(command, cwd=root, capture_output=True, check=True, text=True).stdout


def lines(package: Path) -> int:
    """Lines of the Rust sources of a package that a build may read."""
    sources = (path for path in package.rglob("*.rs") if not LEFT_OUT & set(path.relative_to(package).parts[:-1]))
    return sum(path.read_bytes().count(b"\n") for path in sources)


def compiled(root: Path, package: str) -> dict[str, tuple[bool, int]]:
    """The crates that a package is compiled of: whether each is ours, and its lines."""
    metadata = json.loads(output_of("cargo", "metadata", "--format-version", "1", "--locked", root=root))
    folders = {(each["name"], each["version"]): Path(each["manifest_path"]).parent for each in metadata["packages"]}
    tree = output_of("cargo", "tree", "--locked", "-p", package, "-e", "normal,build", "--prefix", "none", "-f", "{p}", root=root)
    names = {tuple(line.split()[:2]) for line in tree.splitlines() if line.strip()}
    packages = {f"{name} {version}": folders[name, version.removeprefix("v")] for name, version in names}
    return {name: (folder.is_relative_to(root), lines(folder)) for name, folder in packages.items()}


def raised(before: dict, now: dict) -> list[str]:
    """The budgets that are higher now than before."""
    return [
        f"{built}: {what} from {before[built][what]} to {most}"
        for built, budget in now.items()
        for what, most in budget.items()
        if most > before.get(built, {}).get(what, most)
    ]


def unexplained(root: Path) -> list[str]:
    """Budgets raised by commits whose message does not say why; none where git does not answer."""
    found = []
    for file in BUDGETS:
        try:
            commits = output_of("git", "log", "--format=%H", "--", file, root=root).split()
            # The first one sets the budgets.
            for commit in commits[:-1]:
                message = output_of("git", "log", "-1", "--format=%B", commit, root=root)
                if any(line.startswith("Budget:") for line in message.splitlines()):
                    continue
                before, now = (json.loads(output_of("git", "show", f"{of}:{file}", root=root)) for of in (f"{commit}~", commit))
                found += raised(before, now)
        except (OSError, subprocess.CalledProcessError):
            continue
    return found


def main() -> int:
    root = Path(__file__).resolve().parents[1]
    budgets = json.loads((root / ".ci" / "budget.json").read_text())
    too_much = []
    for built, package in BUILT.items():
        crates = compiled(root, package)
        found = {
            "crates": len(crates),
            "own lines": sum(count for own, count in crates.values() if own),
            "other lines": sum(count for own, count in crates.values() if not own),
        }
        for what, most in budgets[built].items():
            print(f"{built}: {found[what]} {what}, {most} allowed")
            if found[what] > most:
                largest = sorted(crates.items(), key=lambda item: -item[1][1])[:10]
                too_much.append(
                    f"The {built} compiles {found[what]} {what}, {most} are allowed. Largest: "
                    + ", ".join(f"{name}: {count}" for name, (_, count) in largest)
                )
    why = [f"Raised without a line \"Budget: ...\" in the message of the commit: {each}" for each in unexplained(root)]
    print(*too_much, *why, sep="\n", end="\n" if too_much or why else "")
    return 1 if too_much or why else 0


if __name__ == "__main__":
    sys.exit(main())
