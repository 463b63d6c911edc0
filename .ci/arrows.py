"""Check which crate and which room of a crate knows which: an arrow that is not listed fails, with file and line.

Reads the dependencies of each Cargo.toml (without those for development) and the paths in the sources. Tests may use anything.
"""

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# What a crate may know, besides what these know. An arrow leads from left to right.
CRATES = {
    "figure": [],
    "model": ["figure"],
    "recording": ["model"],
    "diagnose": ["recording", "figure"],
    "io": ["recording"],
    "population": ["diagnose"],
    "report": ["diagnose"],
    "score": ["population", "report"],
    "stiction": ["io", "score"],
    # Its plants for demonstration and its trial of groups are simulated.
    "plant": ["io", "score"],
    "docs": [],
    # The lessons are pages of the documentation.
    "lab": ["plant", "docs"],
    "fmu": ["model"],
    "fmu-export": ["fmu", "io"],
    "cli": ["stiction", "lab", "fmu-export"],
    "python": ["stiction", "plant", "fmu-export"],
    "train": ["score"],
}
# Stronger than what follows from the above: these must never meet, not even through others.
NEVER = [
    ("figure", ["model", "recording", "diagnose"]),
    ("recording", ["diagnose", "io", "figure"]),
    ("io", ["diagnose", "figure", "report"]),
    ("report", ["io", "population", "score", "plant"]),
    ("population", ["report", "score", "io"]),
    ("score", ["plant", "lab", "io"]),
    ("plant", ["lab", "docs"]),
    ("fmu", ["recording", "diagnose", "figure"]),
]
# Rooms of a crate, from left to right: a room uses those on its left.
ROOMS = {
    "recording": ["spoken", "estimate", "series", "oscillation", "finding", "recording"],
    "diagnose": [
        "cause",
        "drawing",
        "identify",
        "methods",
        "evidence",
        "fusion",
        "diagnose",
        "valve_test",
        "what_if",
        "fit",
    ],
}
# The verdict plans the test that would confirm it.
ALLOWED = {("diagnose", "diagnose", "valve_test")}

errors = []


def name(crate):
    """Return the key of a crate or of the path by which Rust names it."""
    return crate.replace("_", "-").removeprefix("stiction-")


def known(crate):
    """Return everything that a crate may use, directly or through others."""
    return set(CRATES[crate]).union(*(known(one) for one in CRATES[crate]))


def may_use(crate, other):
    """Report whether a crate may use another one."""
    forbidden = {one for who, others in NEVER if who == crate for one in others}
    return other == crate or other in known(crate) and other not in forbidden


def code(path):
    """Yield the numbers and lines of a source file without comments and without its tests."""
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if line.strip() == "mod tests {":
            return
        if not line.lstrip().startswith("//"):
            yield number, line


def main():
    """Check all crates."""
    folders = {name(path.parent.name): path.parent for path in ROOT.glob("crates/*/Cargo.toml")}
    for crate, folder in folders.items():
        if crate not in CRATES:
            errors.append(f"{folder.relative_to(ROOT)}: .ci/arrows.py does not list it")
            continue
        manifest = folder / "Cargo.toml"
        for used in tomllib.loads(manifest.read_text()).get("dependencies", {}):
            if used.startswith("stiction") and not may_use(crate, name(used)):
                line = next(n for n, text in enumerate(manifest.read_text().splitlines(), 1) if text.startswith(used))
                errors.append(f"{manifest.relative_to(ROOT)}:{line}: {crate} must not know {name(used)}")
        rooms = ROOMS.get(crate, [])
        for path in sorted((folder / "src").rglob("*.rs")):
            place = path.relative_to(folder / "src").parts[0].removesuffix(".rs")
            for number, line in code(path):
                where = f"{path.relative_to(ROOT)}:{number}"
                for used in re.findall(r"\bstiction_(\w+)::", line):
                    if name(used) in CRATES and not may_use(crate, name(used)):
                        errors.append(f"{where}: {crate} must not know {name(used)}")
                for used in re.findall(r"\bcrate::(\w+)", line):
                    if place in rooms and used in rooms and rooms.index(used) > rooms.index(place):
                        if (crate, place, used) not in ALLOWED:
                            errors.append(f"{where}: {place} must not know {used}")
    print("\n".join(errors) or f"{len(folders)} crates know only what they may")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
