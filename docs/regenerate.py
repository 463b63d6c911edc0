"""Regenerates parts of the documents: the text between `<!-- stiction ... -->` and `<!-- end -->`.

python3 docs/regenerate.py [path of the command, default target/release/stiction] [documents, default all]
"""

import re
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MARKED = re.compile(r"(<!-- (stiction [^\n]*?) -->\n)(.*?)(<!-- end -->)", re.DOTALL)
# A table with a column for each kind of loop, which is too wide for a page.
TOO_WIDE = re.compile(r"Share of the loops called sticking\.[^\n]*\n\n(?:\|[^\n]*\n)+\n?")


def main() -> None:
    binary = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/release/stiction").resolve()

    def printed(match: re.Match[str]) -> str:
        begin, command, old, end = match.groups()
        print(command, file=sys.stderr)
        # By a shell, for the sake of patterns such as samples/*.csv.
        called = f"{shlex.quote(str(binary))} {command.removeprefix('stiction ')}"
        run = subprocess.run(called, shell=True, cwd=ROOT, capture_output=True, text=True)
        if run.returncode != 0:
            print(f"kept as it was: {run.stderr.strip()}", file=sys.stderr)
            return begin + old + end
        # What is not made for a page stands as it is on the screen.
        narrow = TOO_WIDE.sub("", run.stdout).strip()
        shown = narrow if "--markdown" in command else f"```text\n{narrow}\n```"
        return f"{begin}\n```sh\n{command}\n```\n\n{shown}\n\n{end}"

    for document in [Path(name) for name in sys.argv[2:]] or sorted(ROOT.glob("docs/**/*.md")):
        text = document.read_text()
        if MARKED.search(text):
            document.write_text(MARKED.sub(printed, text))


if __name__ == "__main__":
    main()
