"""Checks the prose of the project against the habits that `docs/style.md` lists.

    python3 .ci/prose.py                         # exit code 1: a habit was found; file and line are printed
    python3 .ci/prose.py --long                  # also lists sentences above 30 words, without failing
    python3 .ci/prose.py --sample 100 --seed 1   # prints random sentences instead, to judge one by one
    python3 .ci/prose.py --sample 100 --shown    # the same, only of what users read: no doc comments of Rust, no tools

It reads Markdown outside code blocks, doc comments and string literals of Rust, docstrings and strings of Python, and strings and
text of the lab's pages. Tests, scripts of benches, generated files, scripts and policies in strings are left out.
"""

import argparse
import ast
import random
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

# A habit and what to write in its stead. `docs/style.md` explains them.
HABITS = {
    r"(?<!cannot[ -])\b(?:tell|tells|told|telling)\b": "report, show, state; distinguish",
    r"\b(?:speaks?|spoke) (?:for|against)\b": "evidence for, evidence against",
    r"\b(?:bears?|borne|bore) out\b": "supports, confirms",
    r"\bthe more so\b|\bwhat is so\b|\b(?:that|this|it) is so\b": "name the fact",
    r"\bthat (?:is|are|was|were) there\b": "existing",
    r"\bas it (?:comes|stands)\b": "unchanged",
    r"\breckon(?:s|ed|ing)?\b": "calculate",
    r"\bmend(?:s|ed|ing)?\b": "fix, repair",
    r"\b(?:seen|sees?|saw) to (?:it|any|by|the)\b": "maintain, ensure",
    r"\bway of the OP\b": "OP travel",
    r"\bin (?:the|its|their) (?:place|stead)(?: of)?\b": "instead of",
    r"\btak(?:e|es|en) (?:\w+ )?for (?:a|an|what|the|granted)\b": "interpreted as",
    r"\bpass(?:es|ed)? over\b": "skip",
    r"\banother than\b|\bin another way\b": "different from; differently",
    r"\bnothing but\b": "only",
    r"\b(?:come|comes|came) out as\b": "result",
    r"\b(?:hold|holds|held) back\b": "suppress, withhold",
    r"\b(?:is|are) said\b|\bsaid to be\b": "reported",
    r"\bmerely\b|\bhowever (?:large|small)\b": "leave it out; of any size",
}
REFUSED = {re.compile(pattern, re.IGNORECASE): write for pattern, write in HABITS.items()}
LONG = 30  # words
SENTENCE = re.compile(r"(?<=[.!?])\s+(?=[A-Z`*(\"])")
# Lists of names and citations have colons and semicolons of their own.
CITATION = re.compile(r"\b(?:19|20)\d\d\b|\bdoi\b|https?:", re.IGNORECASE)
# What a person does not read as prose, or has not written.
LEFT_OUT = re.compile(
    r"(^|/)(tests|benches|node_modules|dist|target|fuzz|font)/|^\.ci/|^docs/(style|python-api)\.md$|/(tests|build)\.rs$|\.test\.tsx?$"
)
# Strings with JavaScript or a Content-Security-Policy.
CODE = re.compile(r"=>|\bdocument\.\w|\bdefault-src\b")
LITERAL = re.compile(
    r"""(?P<doc>//[/!][^\n]*)|//[^\n]*|/\*.*?\*/|r(?P<hash>\#*)"(?P<raw>.*?)"(?P=hash)|"(?P<text>(?:[^"\\]|\\.)*)"|'(?:[^'\\\n]|\\.[^'\n]*)'""",
    re.DOTALL,
)
JSX = re.compile(r">([^<>{}=;]*[a-z]{2,} [^<>{}=;]*)<|\"((?:[^\"\\\n]|\\.)*)\"|`((?:[^`\\]|\\.)*)`")

Text = tuple[int, str]  # line, text


def markdown(source: str) -> Iterator[Text]:
    """Paragraphs outside code blocks."""
    block: list[str] = []
    begun, code = 1, False
    for number, line in enumerate([*source.splitlines(), ""], 1):
        fence = line.lstrip().startswith(("```", "~~~"))
        # Sections, names and examples of docstrings are no sentences.
        named = re.match(r"\s*(?:[\w*, ]+ : |-{3,}$|>>> |\.\.\.( |$))", line)
        if fence or named or not line.strip() or code or line.lstrip().startswith(("|", "#", "* ", "- ", "> ")) or re.match(r"\s*\d+\. ", line):
            if block:
                yield begun, " ".join(block)
            block = []
        code ^= fence
        if not (code or fence or named) and line.strip():
            if not block:
                begun = number
            block.append(line.strip())


def rust(source: str) -> Iterator[Text]:
    """Doc comments, joined over lines, and string literals outside the tests of a file."""
    source = source.split("#[cfg(test)]\nmod tests {")[0]
    doc: list[str] = []
    begun = last = 0
    for found in LITERAL.finditer(source):
        line = source.count("\n", 0, found.start()) + 1
        if found["doc"]:
            if doc and line != last + 1:
                yield from ((begun + at - 1, text) for at, text in markdown("\n".join(doc)))
                doc = []
            if not doc:
                begun = line
            doc.append(found["doc"][3:].strip())
            last = line
        elif not CODE.search(found[0]):
            text = re.sub(r"\\\n\s*", "", found["raw"] or found["text"] or "").replace("\\n", "\n").replace('\\"', '"')
            # Examples below the help of a command are indented.
            text = re.sub(r"^  .*$", "", text, flags=re.MULTILINE)
            yield from ((line, paragraph) for _, paragraph in markdown(text))
    if doc:
        yield from ((begun + at - 1, text) for at, text in markdown("\n".join(doc)))


def python(source: str) -> Iterator[Text]:
    """Docstrings and other strings."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and not CODE.search(node.value):
            yield from ((node.lineno + at - 1, text) for at, text in markdown(node.value))


def pages(source: str) -> Iterator[Text]:
    """Text and strings of the lab's pages."""
    for found in JSX.finditer(re.sub(r"^\s*(?://|\*|/\*).*$", "", source, flags=re.MULTILINE)):
        text = next(filter(None, found.groups()), "")
        if CODE.search(text):
            continue
        yield source.count("\n", 0, found.start()) + 1, " ".join(text.split())


READERS = {".md": markdown, ".rs": rust, ".py": python, ".ts": pages, ".tsx": pages}


def prose(root: Path) -> Iterator[tuple[str, int, str]]:
    """File, line and sentence of all that a person reads."""
    names = subprocess.run(["git", "ls-files"], cwd=root, capture_output=True, check=True, text=True).stdout.splitlines()
    for name in names:
        reader = READERS.get(Path(name).suffix)
        if reader and not LEFT_OUT.search(name):
            for line, text in reader((root / name).read_text()):
                # Code and addresses are not prose.
                plain = re.sub(r"``.*?``|`[^`]*`", "`x`", text)
                plain = re.sub(r"\]\([^)]*\)", "]", plain)
                plain = re.sub(r"\{\w+\}", "{}", plain)
                yield from ((name, line, sentence) for sentence in SENTENCE.split(plain) if len(sentence.split()) > 2)


# What only those read who change or release the project.
OF_DEVELOPERS = re.compile(r"^(release|addons/stiction-train)/|/(examples|benchmarks)/|^(CONTRIBUTING|ARCHITECTURE)\.md$|^crates/stiction-diagnose/model/")


def is_shown(root: Path, name: str, line: int) -> bool:
    """Whether users read a sentence: not in a doc comment of Rust, unless a command prints it as its help."""
    source = (root / name).read_text()
    is_comment = name.endswith(".rs") and source.splitlines()[line - 1].lstrip().startswith("//")
    return not OF_DEVELOPERS.search(name) and (not is_comment or "use clap" in source)


def faults(sentence: str) -> Iterator[str]:
    """Habits of a sentence, and what to write."""
    for pattern, write in REFUSED.items():
        if found := pattern.search(sentence):
            yield f"“{found[0]}”: {write}"
    chained = re.sub(r"\{[^}]*\}|::|\d:\d|\"[^\"]*\"", "", sentence)
    if not CITATION.search(sentence) and not sentence.startswith("|"):
        if len(re.findall(r":(?=\s)", chained)) > 1:
            yield "two colons: split the sentence"
        if chained.count(";") > 2:
            yield "three semicolons: split the sentence"


def main() -> int:
    """The check of the project in the folder above."""
    asked = argparse.ArgumentParser(description="Checks the prose of the project against docs/style.md.")
    asked.add_argument("--long", action="store_true", help=f"list sentences above {LONG} words, too")
    asked.add_argument("--sample", type=int, metavar="N", help="print N random sentences instead")
    asked.add_argument("--seed", type=int, default=1, help="seed of the sample (1)")
    asked.add_argument("--shown", action="store_true", help="only sentences that users read, without doc comments of Rust")
    asked.add_argument("--only", default="", help="only files whose path begins with this")
    options = asked.parse_args()
    root = Path(__file__).parents[1]
    all_of_it = [each for each in prose(root) if each[0].startswith(options.only)]
    if options.sample:
        sentences = [each for each in all_of_it if len(each[2].split()) > 4]
        if options.shown:
            sentences = [each for each in sentences if is_shown(root, *each[:2])]
        for name, line, sentence in random.Random(options.seed).sample(sentences, min(options.sample, len(sentences))):
            print(f"{name}:{line}: {sentence}")
        return 0
    count = 0
    for name, line, sentence in all_of_it:
        for fault in faults(sentence):
            count += 1
            print(f"{name}:{line}: {fault}: {sentence[:160]}")
        if options.long and not sentence.startswith("|") and len(sentence.split()) > LONG:
            print(f"{name}:{line}: {len(sentence.split())} words: {sentence[:160]}")
    if count:
        print(f"{count} habits found. docs/style.md says what to write.", file=sys.stderr)
    return int(count > 0)


if __name__ == "__main__":
    sys.exit(main())
