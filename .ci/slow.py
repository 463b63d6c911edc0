"""Decides whether a slow and rarely touched check has to run.

    python3 .ci/slow.py due NAME    # exit code 0: it has to run
    python3 .ci/slow.py passed NAME...    # stores that these passed on the files as they are

A check is due if the files that it looks at differ from those on which it last passed (`.ci/slow.json`, which is committed), or if
CI_ALL=1 is set.
"""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

# What each check looks at: files and folders, from the root of the repository.
CHECKS = {
    "importer": [
        "crates/stiction-cli/src/fmu.rs",
        "addons/stiction-fmu",
        "addons/stiction-fmu-export",
        "crates/stiction-model/src",
        "importers",
    ],
    "live": [
        "addons/stiction-plant/src",
        "addons/stiction-python/src/plant.rs",
        "pyproject.toml",
        "python/benchmarks/live.py",
        "python/stiction/live",
        "python/stiction/plant",
        "python/tests/live",
    ],
    "notebooks": ["addons/stiction-python", "pyproject.toml", "python/notebooks", "python/stiction"],
    "spark": [
        "addons/stiction-plant/src",
        "addons/stiction-python/src/plant.rs",
        "addons/stiction-python/src/plant_table.rs",
        "pyproject.toml",
        "python/stiction/plant",
        "python/tests/spark",
    ],
}


def fingerprint(root: Path, inputs: list[str]) -> str:
    """The SHA-256 of the names and contents of all files of git among the inputs."""
    listed = subprocess.run(["git", "ls-files", "-z", "--", *inputs], cwd=root, capture_output=True, check=True)
    names = sorted(name for name in listed.stdout.decode().split("\0") if name)
    if not names:
        raise SystemExit(f"no files of git among {', '.join(inputs)}")
    whole = hashlib.sha256()
    for name in names:
        path = root / name
        content = path.read_bytes() if path.is_file() else b""
        whole.update(f"{name}\0{len(content)}\0".encode())
        whole.update(content)
    return whole.hexdigest()


def due(root: Path, name: str) -> bool:
    """Whether a check has to run."""
    if os.environ.get("CI_ALL") == "1":
        return True
    stored = root / ".ci" / "slow.json"
    passed = json.loads(stored.read_text()) if stored.exists() else {}
    try:
        return passed.get(name) != fingerprint(root, CHECKS[name])
    except (OSError, subprocess.CalledProcessError) as error:
        # Without git nothing is known of the files.
        print(f"{name} is due: {error}", file=sys.stderr)
        return True


def store(root: Path, names: list[str]) -> None:
    """Stores that checks passed."""
    stored = root / ".ci" / "slow.json"
    passed = json.loads(stored.read_text()) if stored.exists() else {}
    passed |= {name: fingerprint(root, CHECKS[name]) for name in names}
    stored.write_text(json.dumps(passed, indent=2, sort_keys=True) + "\n")


def main(root: Path, arguments: list[str]) -> int:
    match arguments:
        case ["due", name] if name in CHECKS:
            return 0 if due(root, name) else 1
        case ["passed", *names] if names and all(name in CHECKS for name in names):
            store(root, names)
            return 0
    print(f"{__doc__}\nChecks: {', '.join(CHECKS)}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(Path(__file__).resolve().parents[1], sys.argv[1:]))
