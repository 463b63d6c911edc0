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
    """Return a source file without comments and without its tests, line by line as before."""
    whole = path.read_text().split("\nmod tests {")[0]
    return re.sub(r"(?m)^[ \t]*//.*$", "", whole)


def used_rooms(text):
    """Yield the offsets and first names of all paths from the root of the crate, also those in braces."""
    for found in re.finditer(r"\bcrate::(?:(\w+)|\{)", text):
        if found[1]:
            yield found.start(), found[1]
            continue
        depth, begin = 1, found.end()
        for at in range(begin, len(text)):
            depth += {"{": 1, "}": -1}.get(text[at], 0)
            if depth == 0 or depth == 1 and text[at] == ",":
                yield begin, text[begin:at].split("::")[0].strip()
                begin = at + 1
            if depth == 0:
                break


def main():
    """Check all crates."""
    folders = {name(path.parent.name): path.parent for path in [*ROOT.glob("crates/*/Cargo.toml"), *ROOT.glob("addons/*/Cargo.toml")]}
    for crate, folder in folders.items():
        if crate not in CRATES:
            errors.append(f"{folder.relative_to(ROOT)}: .ci/arrows.py does not list it")
            continue
        manifest = folder / "Cargo.toml"
        whole = tomllib.loads(manifest.read_text())
        parts = [whole, *whole.get("target", {}).values()]
        for used in (used for part in parts for used in part.get("dependencies", {})):
            if used.startswith("stiction") and not may_use(crate, name(used)):
                line = next(n for n, text in enumerate(manifest.read_text().splitlines(), 1) if text.startswith(used))
                errors.append(f"{manifest.relative_to(ROOT)}:{line}: {crate} must not know {name(used)}")
        rooms = ROOMS.get(crate, [])
        for path in sorted((folder / "src").rglob("*.rs")):
            place = path.relative_to(folder / "src").parts[0].removesuffix(".rs")
            text = code(path)
            where = lambda at: f"{path.relative_to(ROOT)}:{1 + text.count(chr(10), 0, at)}"
            for found in re.finditer(r"\bstiction_(\w+)::", text):
                if name(found[1]) in CRATES and not may_use(crate, name(found[1])):
                    errors.append(f"{where(found.start())}: {crate} must not know {name(found[1])}")
            for at, used in used_rooms(text):
                if place in rooms and used in rooms and rooms.index(used) > rooms.index(place):
                    if (crate, place, used) not in ALLOWED:
                        errors.append(f"{where(at)}: {place} must not know {used}")
    print("\n".join(errors) or f"{len(folders)} crates know only what they may")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
