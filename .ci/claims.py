"""Checks that every figure in the documents has a source (`docs/claims.toml`).

    python3 .ci/claims.py                       # exit code 1: a figure has no source, or differs from it
    python3 .ci/claims.py target/debug/stiction # also runs the commands of those that take seconds, and compares

A figure is a percentage, a share, a duration or a size in the prose or a table of a page. Its entry in `docs/claims.toml` names the
text of the page and one of

* `run` and `prints`: a command that takes at most seconds, and what its output must contain
* `file` and `has`: a file of the repository and a text in it, such as a stored output with its command, or a constant
* `measured`: day and commit of a measurement that takes longer, or cannot be repeated here
* `given = true`: an example, a definition or a setting of the reader, which nothing measures

In `prints` and `has`, `...` stands for any text. `says` may be the head of a table, and then stands for all of its rows.

Pages whose figures stand in tables of measurements (`MEASURED`) name a command in each section instead, or the source file with
these figures. The tables of the models' cards (`CARDS`) are output of the training. The entries of `--help` are for the help of all
commands, which is read if a binary is given, without its examples.
"""

import functools
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CLAIMS = ROOT / "docs" / "claims.toml"
# Cards of models.
CARDS = {"crates/stiction-diagnose/model/README.md", "crates/stiction-diagnose/model/VALVES.md"}
PAGES = ["README.md", "python/README.md", "docs/*.md", "samples/*.md", "paper/*.md", *sorted(CARDS)]
HELP = "--help"
# Pages of measurements.
MEASURED = {
    "docs/accuracy.md",
    "docs/accuracy-loops.md",
    "docs/accuracy-tests.md",
    "docs/every-method.md",
    "docs/population.md",
    "BENCHMARKS.md",
}
# Written by a program, or not about the program.
LEFT_OUT = {"docs/style.md", "docs/python-api.md", "docs/methods.md", "docs/crates.md", "CHANGELOG.md", "CONTRIBUTING.md", "ARCHITECTURE.md"}
NUMBER = r"(?<![\w.])\d[\d,.]*"
WORD = r"(?:one|two|three|four|five|six|seven|eight|nine|ten|twelve|twenty)"
FIGURE = re.compile(
    rf"{NUMBER} ?%|{NUMBER} of (?:the )?{NUMBER}|{NUMBER} (?:ns|µs|ms|s|min|h|kB|MB|GB|times)\b"
    rf"|\b{WORD} (?:in|of) (?:a |the )?(?:hundred|{WORD}|{NUMBER})\b"
    # A default value that a help text has by hand. Those of the parser stand alone.
    r"|(?<=\S )\[default: [^\]]*(?<!\w)\d"
)
# The confidence of an interval or of a limit, which every page repeats.
CONFIDENCE = re.compile(r"9[05] %[ -](?:intervals?|confidence)|\bwith 95 % confidence|\(9[05] %\)")
COMMAND = r"(?:stiction|cargo|python\d?|\.ci/|release/)"
SENTENCE = re.compile(r"(?<=[.!?:])\s+(?=[A-Z`*(\"])")


def plain(text: str) -> str:
    """A text with single blanks."""
    return " ".join(text.split())


def without_code(text: str) -> str:
    """A page without code, outputs and comments, with as many lines."""
    blank = lambda found: "\n" * found[0].count("\n")
    return re.sub(r"<!--.*?-->", blank, re.sub(r"^( *)```.*?^\1```", blank, text, flags=re.S | re.M), flags=re.S)


def statements(text: str) -> Iterator[tuple[int, str, str]]:
    """Each sentence and each row of a table, with its line and the head of the table."""
    line = 1
    for block in re.split(r"(\n\s*\n)", without_code(text)):
        if block.lstrip().startswith("|"):
            rows = [plain(row) for row in block.split("\n")]
            yield from ((line + n, row, rows[0]) for n, row in enumerate(rows))
        elif not block.startswith("#"):
            for item in re.split(r"\n(?= *(?:[*-]|\d+\.) )", block):
                yield from ((line, sentence, "") for sentence in SENTENCE.split(plain(item)))
        line += block.count("\n")


def pages() -> list[str]:
    """The pages that a user reads."""
    listed = subprocess.run(["git", "ls-files", *PAGES], cwd=ROOT, capture_output=True, text=True, check=True)
    return [name for name in listed.stdout.split() if name not in LEFT_OUT | MEASURED]


def text_of(page: str) -> str:
    """A page, or the prose of a card, with as many lines."""
    text = (ROOT / page).read_text()
    return re.sub(r"^\|.*", "", text, flags=re.M) if page in CARDS else text


def unsourced(page: str, text: str, claims: list[dict]) -> Iterator[str]:
    """The figures of a page without an entry, and the entries whose text the page has no longer."""
    says = [claim["says"] for claim in claims]
    whole = plain(without_code(text))
    for claim in says:
        if claim not in whole:
            yield f"{page}: docs/claims.toml names a text that is not there: {claim!r}"
    for line, statement, head in statements(text):
        sourced = any(claim in statement or statement in claim or claim == head for claim in says)
        if FIGURE.search(CONFIDENCE.sub("", statement)) and not sourced:
            yield f"{page}:{line}: no source in docs/claims.toml: {statement}"


def contains(output: str, wanted: str) -> bool:
    """Whether an output has a text, in which `...` stands for any."""
    return re.search(".*".join(re.escape(plain(part)) for part in wanted.split("...")), plain(output)) is not None


@functools.cache
def output(command: str, program: str) -> str:
    """What a command prints."""
    run = subprocess.run(f'stiction() {{ {shlex.quote(program)} "$@"; }}; {command}', shell=True, cwd=ROOT, capture_output=True, text=True)
    return run.stdout + run.stderr


def helps(program: str, *command: str) -> Iterator[str]:
    """The help of a command and of its subcommands, without examples."""
    text = output(shlex.join(["stiction", *command, HELP]), program)
    yield re.sub(r"^Examples?:\n(?:(?: .*)?\n)*", "", text, flags=re.M)
    listed = re.search(r"^Commands:\n(.*?)\n\n", text, re.S | re.M)
    for name in re.findall(r"^  ([\w-]+)", listed[1] if listed else "", re.M):
        if name != "help":
            yield from helps(program, *command, name)


def help_of(program: str) -> str:
    """The help of all commands, with each block once, as many share options."""
    return "\n\n".join(dict.fromkeys(block for text in helps(program) for block in re.split(r"\n\s*\n", text)))


def contradicted(page: str, claim: dict, program: str | None) -> str | None:
    """Why the source of a claim does not support it; `None` if it does."""
    match claim:
        case {"given": True} if len(claim) == 2:
            return None
        case {"measured": str(when)} if len(claim) == 2 and re.match(r"\d{4}-\d\d-\d\d\b", when):
            return None
        case {"file": file, "has": has} if len(claim) == 3:
            path = ROOT / file
            if not path.is_file() or not contains(path.read_text(), has):
                return f"{page}: {claim['says']!r}: {file} lacks {has!r}"
        case {"run": command, "prints": prints} if len(claim) == 3:
            if program is not None and not contains(output(command, program), prints):
                return f"{page}: {claim['says']!r}: {command} prints no {prints!r}, but\n{output(command, program)}"
        case _:
            return f"{page}: {claim.get('says')!r} needs `run` and `prints`, `file` and `has`, `measured` with a date, or `given = true`"
    return None


def commandless(page: str, text: str) -> Iterator[str]:
    """The sections of a page of measurements that have figures and name no command, nor a source file with them."""
    for section in re.split(r"\n(?=## )", text)[1:]:
        title, _, body = section.partition("\n")
        if FIGURE.search(without_code(body)) and not re.search(rf"```sh|```text\n{COMMAND}|`{COMMAND}[^`]*`|`[\w/]+\.rs`|\]\(", body):
            yield f"{page}: {title.strip('# ')}: figures without a command or a source file"


def main() -> int:
    program = str(Path(sys.argv[1]).resolve()) if len(sys.argv) > 1 else None
    claims = tomllib.loads(CLAIMS.read_text())
    faults = []
    for page in pages():
        faults += unsourced(page, text_of(page), claims.pop(page, []))
    of_help = claims.pop(HELP, [])
    if program is not None:
        faults += unsourced(HELP, help_of(program), of_help)
    for page in MEASURED:
        faults += commandless(page, (ROOT / page).read_text())
    faults += [f"docs/claims.toml: there is no page {page}" for page in claims]
    for page, listed in tomllib.loads(CLAIMS.read_text()).items():
        faults += filter(None, (contradicted(page, claim, program) for claim in listed))
    for fault in faults:
        print(fault, file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
