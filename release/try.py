"""Try a released program of another platform. The same sessions by this program and by the Linux program are compared.

    python release/try.py OUT/stiction-0.1.0-x86_64-pc-windows-gnu.zip --like OUT/stiction-0.1.0-x86_64-unknown-linux-gnu.tar.xz
    python release/try.py OUT/stiction-0.1.0-aarch64-unknown-linux-gnu.tar.xz --like ...

Windows programs run in Wine, and ARM programs in QEMU. The folder of the trial has a space and an umlaut in its name. Texts must be
equal but for path marks. Numbers may differ in their last digits, because platforms have `exp` and `sin` of their own. The largest
relative difference is printed, and the exit code is 1 if one exceeds 1e-6 or a text differs. At the end a host of FMUs, compiled for
the platform, moves the valve of the exported FMU. The stem positions must have the same bits.
"""

from __future__ import annotations

import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import zipfile

STAND_IN = pathlib.Path(__file__).with_name("bcryptprimitives.c")
FMU_HOST = pathlib.Path(__file__).with_name("fmu_host.c")
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")
TOLERANCE = 1e-6
# Predicted effects come from simulated loops, in which a slip amplifies the last digit. Reports and orders have them, too. What is
# measured in a recording is compared strictly by `diagnose --json`.
PREDICTED, TOLERANCE_PREDICTED = {"what-if", "--report", "orders"}, 0.1

STICKY = "samples/FIC101-sticky.csv"
# Files that cannot be read.
UNREADABLE = ["none.csv", "CON.csv"]
# What is run, and the files that it writes and that are compared.
SESSIONS: list[tuple[list[str], list[str]]] = [
    (["--version"], []),
    (["diagnose", STICKY], []),
    (["diagnose", STICKY, "--json"], []),
    (["diagnose", "Prüfung 1.csv", "--report", "Bericht ä.html"], ["Bericht ä.html"]),
    (["diagnose", "crlf.csv", "--json"], []),
    (["diagnose", "@ABSOLUTE@/Prüfung 1.csv", "--brief"], []),
    (["diagnose", "samples/FIC101-sticky.csv", "samples/LIC104-quantised.csv", "--csv", "-"], []),
    (["diagnose", "latin.csv"], []),
    (["diagnose", "none.csv"], []),
    (["diagnose", "CON.csv"], []),
    (["inspect", STICKY, "--json"], []),
    (["history", STICKY, "--json"], []),
    (["fit", STICKY, "--json"], []),
    (["what-if", STICKY, "--json"], []),
    (["limit-cycle", "paper/closed-loop", "--json"], []),
    (["simulate", "paper/closed-loop", "-o", "run.csv", "--plot", "run.svg"], ["run.csv", "run.svg"]),
    (["compensate", "samples/sticky-flow", "--json"], []),
    (["test", "plan", STICKY, "--json"], []),
    (["test", "plan", STICKY, "--sheet", "sheet.html"], ["sheet.html"]),
    (["population", "--n", "3", "--seed", "5", "-o", "population"], []),
    (["diagnose", *(f"shared/loop-{k:02}.csv" for k in range(32)), "--csv", "-"], []),
    (["plant", "demo", "--loops", "3", "--days", "1", "-o", "Werk Süd"], ["Werk Süd/plant.toml", "Werk Süd/truth.csv"]),
    (["plant", "-C", "Werk Süd", "scan"], []),
    (["plant", "-C", "Werk Süd", "status"], []),
    (["plant", "-C", "Werk Süd", "report"], []),
    (["plant", "-C", "Werk Süd", "orders", "--json"], []),
    (["fmu", "--model", "two-phase", "--S", "5", "--J", "3", "-o", "valve.fmu"], []),
    (["figures", "-o", "figures"], []),
    (["schema", "diagnosis"], []),
    (["completions", "powershell"], []),
    (["man", "manual"], ["manual/stiction.1"]),
]


class Program:
    """An unpacked release that can be run here."""

    def __init__(self, archive: pathlib.Path, folder: pathlib.Path) -> None:
        folder.mkdir(parents=True)
        if archive.suffix == ".zip":
            with zipfile.ZipFile(archive) as packed:
                packed.extractall(folder)
        else:
            with tarfile.open(archive) as packed:
                packed.extractall(folder, filter="data")
        [self.folder] = folder.iterdir()
        self.environment = dict(os.environ, LANG="C.UTF-8", HOME=str(folder / "home"), BROWSER="true")
        self.environment.pop("RUST_BACKTRACE", None)
        self.before: list[str] = []
        self.compiler, self.libraries = "gcc", "x86_64-linux"
        own = self.folder / "stiction"
        if "windows" in archive.name:
            own = self.folder / "stiction.exe"
            self.before = [found("wine")]
            self.compiler, self.libraries = "x86_64-w64-mingw32-gcc", "x86_64-windows"
            self.environment |= {"WINEDEBUG": "-all", "WINEPREFIX": str(folder / "wine")}
            library = self.folder / "bcryptprimitives.dll"
            subprocess.run(["x86_64-w64-mingw32-gcc", "-shared", "-o", library, STAND_IN, "-ladvapi32"], check=True)
            subprocess.run([*self.before, "wineboot", "-i"], env=self.environment, check=True, capture_output=True)
        elif "aarch64" in archive.name:
            self.before = [found("qemu-aarch64-static"), "-L", "/usr/aarch64-linux-gnu"]
            self.compiler, self.libraries = "aarch64-linux-gnu-gcc", "aarch64-linux"
        self.own = own
        sticky = (self.folder / STICKY).read_text()
        (self.folder / "Prüfung 1.csv").write_text(sticky)
        (self.folder / "crlf.csv").write_bytes(sticky.replace("\n", "\r\n").encode())
        (self.folder / "latin.csv").write_bytes(sticky.replace("pv", "Größe", 1).encode("latin-1"))

    def run(self, words: list[str]) -> tuple[int, str, str]:
        """Run the program in its folder: exit code, output, messages."""
        absolute = f"Z:{self.folder}".replace("/", "\\") if self.own.suffix == ".exe" else str(self.folder)
        words = [word.replace("@ABSOLUTE@", absolute) for word in words]
        if self.own.suffix == ".exe":
            words = [word.replace("/", "\\") if word.startswith(("samples/FIC", "Z:")) else word for word in words]
        done = subprocess.run(
            [*self.before, self.own, *words], cwd=self.folder, env=self.environment, capture_output=True, stdin=subprocess.DEVNULL, check=False
        )
        return done.returncode, self.plain(done.stdout), self.plain(done.stderr)

    def valve(self, fmu: pathlib.Path) -> str:
        """The stem positions of the valve in an FMU, by the library for the platform of this program."""
        # The host is a plain C program, and Windows programs without a manifest have no umlauts in paths.
        unpacked = pathlib.Path(tempfile.mkdtemp(prefix="fmu-", dir=fmu.parents[3]))
        with zipfile.ZipFile(fmu) as packed:
            packed.extractall(unpacked)
        [library] = (unpacked / "binaries" / self.libraries).iterdir()
        [token] = re.findall(r'instantiationToken="([^"]*)"', (unpacked / "modelDescription.xml").read_text())
        host = unpacked / ("host.exe" if self.own.suffix else "host")
        subprocess.run([found(self.compiler), "-O1", "-o", host, FMU_HOST, *([] if self.own.suffix else ["-ldl"])], check=True)
        resources = f"{unpacked / 'resources'}/"
        places = [f"Z:{place}".replace("/", "\\") if self.own.suffix else str(place) for place in (library, resources)]
        done = subprocess.run([*self.before, host, places[0], token, places[1]], env=self.environment, capture_output=True, check=False, text=True)
        return f"exit code {done.returncode}\n{done.stdout}"

    def plain(self, said: bytes) -> str:
        """Output without differences between platforms: separators of paths, line ends and messages of the operating system."""
        # The words of the operating system for a missing file are its own, and Wine names no file for `CON.csv`.
        said = re.sub(rb"(?<=\.csv: ).*\(os error \d+\).*", b"(os error)", said)
        text = said.decode(errors="replace").replace("\\\\", "/").replace("\\", "/").replace("\r\n", "\n")
        return text.replace(f"Z:{self.folder}", "@").replace(str(self.folder), "@").replace("stiction.exe", "stiction")


def found(name: str) -> str:
    """The path of a program."""
    return shutil.which(name) or sys.exit(f"{name} is missing")


def difference(own: str, other: str) -> float | None:
    """The largest relative difference of numbers between two texts, or None if their words differ."""
    if own == other:
        return 0.0
    if NUMBER.sub("#", own) != NUMBER.sub("#", other):
        return None
    largest = 0.0
    for a, b in zip(map(float, NUMBER.findall(own)), map(float, NUMBER.findall(other)), strict=True):
        # What is a thousandth of a thousandth of 1 is nothing: rounding about zero.
        largest = max(largest, abs(a - b) / max(abs(a), abs(b), 1e-6))
    return largest


def main() -> None:
    """Run the sessions by both programs, and print what differs."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("archive", type=pathlib.Path)
    asked.add_argument("--like", type=pathlib.Path, required=True)
    options = asked.parse_args()
    failed = 0
    with tempfile.TemporaryDirectory() as temporary:
        own, like = (
            Program(archive, pathlib.Path(temporary) / name / "Prüf stand")
            for archive, name in [(options.archive, "own"), (options.like, "like")]
        )
        # Both judge the same loops. A slip can turn the last digit of a simulation into a different recording.
        like.run(["population", "--n", "32", "--seed", "101", "-o", "shared"])
        shutil.copytree(like.folder / "shared", own.folder / "shared")
        for words, files in SESSIONS:
            from_ = time.monotonic()
            one = own.run(words)
            seconds = time.monotonic() - from_
            two = like.run(words)
            texts = [(one[1], two[1]), (one[2], two[2])]
            for name in files:
                pair = [program.folder / name for program in (own, like)]
                if not all(path.is_file() for path in pair):
                    texts.append((name, "is missing"))
                    continue
                texts.append(tuple(program.plain(path.read_bytes()) for program, path in zip((own, like), pair, strict=True)))
            found_ = [difference(a, b) for a, b in texts]
            expected = 2 if words[-1] in UNREADABLE else 0
            differs = {one[0], two[0]} != {expected} or None in found_
            largest = max((each for each in found_ if each is not None), default=0.0)
            failed += differs or largest > (TOLERANCE_PREDICTED if PREDICTED & set(words) else TOLERANCE)
            verdict = "DIFFERS" if differs else "equal" if largest == 0 else f"numbers differ by {largest:.1e} at most"
            print(f"{verdict:36} {seconds:6.1f} s  stiction {' '.join(words)[:120]}", flush=True)
            if differs:
                print(f"    exit codes {one[0]} and {two[0]}, expected {expected}; {one[2][-300:].strip()}")
                for a, b in texts:
                    if difference(a, b) is None:
                        lines = list(zip(a.splitlines(), b.splitlines(), strict=False))
                        first = next((pair for pair in lines if difference(*pair) is None), (a[-200:], b[-200:]))
                        print(f"    {first[0][:300]}\n    {first[1][:300]}")
        export = ["fmu", "--fmi", "3", "--model", "two-phase", "--S", "5", "--J", "3", "-o", "valve3.fmu"]
        own.run(export)
        moved = [program.valve(own.folder / "valve3.fmu") for program in (own, like)]
        equal = moved[0] == moved[1] and moved[0].startswith("exit code 0\nFMI 3.0\n")
        failed += not equal
        print(f"{'equal' if equal else 'DIFFERS':36}          the valve of the FMU, {len(moved[0].splitlines()) - 2} steps")
    print(f"{len(SESSIONS) + 1 - failed} passed, {failed} failed")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
