"""Compare what two versions promise: keys of JSON documents, subcommands and options, and names and parameters in Python.

    python release/promise.py OLD/stiction NEW/stiction
    python release/promise.py OLD/stiction NEW/stiction --python OLD/environment/bin/python NEW/environment/bin/python

The script lists all that the new version breaks, and exits with 1 if there is anything. Additions break nothing. A Python name
that leaves `stiction` itself and stays in its module is not listed. Columns of CSV and Parquet files are tested in the crates. The
Rust API is not compared.
"""

from __future__ import annotations

import argparse
import json
import pathlib
import re
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

# Run by both Pythons.
SIGNATURES = pathlib.Path(__file__).with_name("signatures.py")


def printed(*words: object) -> str:
    """What a program prints."""
    return subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, text=True, check=True).stdout


def schemas(program: pathlib.Path) -> dict[str, Any]:
    """The schema of each document that a program prints."""
    values = re.search(r"\[possible values: ([^\]]*)\]", printed(program, "schema", "--help"))
    if values is None:
        sys.exit(f"{program}: the documents are not listed by schema --help")
    names = re.split(r",\s*", values[1])
    return {name: json.loads(printed(program, "schema", name)) for name in names}


def options(program: pathlib.Path) -> set[str]:
    """Each subcommand with each of its options, from the completions."""
    found = set()
    for line in printed(program, "completions", "fish").splitlines():
        places = [r"using_subcommand ([\w-]+)", r"(?<!not )__fish_seen_subcommand_from ([\w-]+)"]
        words = " ".join(seen[1] for place in places if (seen := re.search(place, line)))
        option = re.search(r" -l ([\w-]+)", line)
        command = re.search(r' -a "([\w-]+)"', line)
        if option:
            found.add(f"{words} --{option[1]}".strip())
        elif command:
            found.add(f"{words} {command[1]}".strip())
    return found


def kinds(of: dict[str, Any]) -> set[str]:
    """The types of a value."""
    kind = of.get("type", [])
    return {kind} if isinstance(kind, str) else set(kind)


def resolved(of: Any, whole: dict[str, Any]) -> Any:
    """A part of a schema, with its reference followed."""
    while isinstance(of, dict) and "$ref" in of:
        of = whole["$defs"][of["$ref"].rsplit("/", 1)[1]]
    return of


def keys(whole: dict[str, Any]) -> dict[str, tuple[set[str], bool]]:
    """Each key of a schema by its path, with its types and whether it is always present."""

    def walk(of: Any, path: str, above: tuple[str, ...]) -> Iterator[tuple[str, tuple[set[str], bool]]]:
        reference = of.get("$ref") if isinstance(of, dict) else None
        if reference in above or not isinstance(of, dict):
            return
        above = (*above, reference) if reference else above
        of = resolved(of, whole)
        for name, part in of.get("properties", {}).items():
            yield f"{path}.{name}", (kinds(resolved(part, whole)), name in of.get("required", []))
            yield from walk(part, f"{path}.{name}", above)
        if "items" in of:
            yield from walk(of["items"], f"{path}[]", above)
        if isinstance(of.get("additionalProperties"), dict):
            yield from walk(of["additionalProperties"], f"{path}.*", above)
        for word in ("anyOf", "oneOf", "allOf"):
            for part in of.get(word, []):
                yield from walk(part, path, above)

    found: dict[str, tuple[set[str], bool]] = {}
    for path, (types, always) in walk(whole, "", ()):
        # A key of several variants has the types of all, and is there if all have it.
        known, before = found.get(path, (set(), True))
        found[path] = known | types, before and always
    return found


def broken_keys(document: str, old: dict[str, Any], new: dict[str, Any]) -> Iterator[str]:
    """Keys that are gone, have another type, or may now be missing."""
    after = keys(new)
    for path, (types, always) in keys(old).items():
        name = f"{document}: {path[1:]}"
        if path not in after:
            yield f"{name} is gone"
        elif types and not after[path][0] <= types:
            yield f"{name} may be {', '.join(sorted(after[path][0] - types))} now"
        elif always and not after[path][1]:
            yield f"{name} may be missing now"


def broken_calls(old: dict[str, Any], new: dict[str, Any]) -> Iterator[str]:
    """Python names that were removed, parameters that were removed or are now required, and parameters at another position."""
    in_modules = {re.sub(r"^stiction\.\w+", "stiction", name) for name in new}
    for name, parameters in old.items():
        if name not in new:
            if name not in in_modules:
                yield f"{name} is gone"
            continue
        if parameters is None or new[name] is None:
            continue
        after = {own: (kind, optional) for own, kind, optional in new[name]}
        for own, kind, optional in parameters:
            if own not in after:
                yield f"{name}: the parameter {own} is gone"
            elif optional and not after[own][1]:
                yield f"{name}: the parameter {own} must be given now"
            elif kind.startswith("POSITIONAL") and not after[own][0].startswith("POSITIONAL"):
                yield f"{name}: the parameter {own} must be named now"
        before = [own for own, kind, _ in parameters if kind.startswith("POSITIONAL")]
        kept = [own for own, kind, _ in new[name] if kind.startswith("POSITIONAL")]
        if all(own in after for own in before) and kept[: len(before)] != before and set(before) <= set(kept):
            yield f"{name}: parameters are in another order"
        known = {own for own, *_ in parameters}
        for own, _, optional in new[name]:
            if own not in known and not optional:
                yield f"{name}: the new parameter {own} must be given"


def main() -> int:
    """Read the arguments, compare, and print what is broken."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("old", type=pathlib.Path, help="the program of the last release")
    asked.add_argument("new", type=pathlib.Path, help="the program of this one")
    asked.add_argument("--python", nargs=2, metavar=("OLD", "NEW"), help="Pythons that have the wheels of both")
    given = asked.parse_args()
    before, now = schemas(given.old), schemas(given.new)
    broken = [f"the document {name} is gone" for name in before if name not in now]
    for name in before.keys() & now.keys():
        broken += broken_keys(name, before[name], now[name])
    broken += [f"stiction {words} is gone" for words in options(given.old) - options(given.new)]
    if given.python:
        old, new = (json.loads(printed(python, SIGNATURES)) for python in given.python)
        broken += broken_calls(old, new)
    print("\n".join(sorted(broken)) or "nothing is broken")
    return int(bool(broken))


if __name__ == "__main__":
    sys.exit(main())
