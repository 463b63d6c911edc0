"""Writes `python/stiction/_document.py`, the classes of a diagnosis from its schema, and `docs/python-api.md`, every public
name of the Python package with its parameters and the first sentence of its documentation.

python3 docs/python_api.py

It reads the sources and runs none, so the package need not be installed. Parameters come from the modules and from `_core.pyi`.
Documentation comes from doc strings and, for compiled classes, from the Rust files.
"""

from __future__ import annotations

import ast
import json
import keyword
import re
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "python" / "stiction"
COMPILED = ROOT / "crates" / "stiction-python" / "src"
PAGE = ROOT / "docs" / "python-api.md"
SCHEMA = ROOT / "docs" / "diagnosis.schema.json"
CLASSES = PACKAGE / "_document.py"
HEAD = """# Python API

The names of every module, each with its parameters, what it returns, and the first sentence of its documentation. Parameters in
brackets are optional, and those after `*` are given by name. The docstrings describe parameters, equations, results and errors, with
examples. `help` prints them, as in `help(stiction.cycles.limit_cycle)`.

{top}

Every result unpacks in the order of its attributes, and has `to_dict()`. `python3 docs/python_api.py` makes this page, and a test
checks it.
"""
CLASSES_HEAD = '''"""Results of a diagnosis, with the descriptions of its JSON schema.

Made by `python3 docs/python_api.py` from `docs/diagnosis.schema.json` and checked by a test.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from stiction._result import Result, about, result
from stiction.detection import Finding
from stiction.oscillations import Oscillation
from stiction.recordings import Fitness

__all__ = [
'''
#: Classes that are not made from the schema, because the package has them elsewhere or lacks them.
ELSEWHERE = {
    *("Finding", "Fitness", "Line", "Measure", "Number", "Weighing"),
    *("Episode", "Oscillation", "Peak", "Supervised", "Kpis", "Override", "Source"),
}
#: Names of classes, if different from the schema.
CALLED = {"GridRepair": "Mended", "Loop": "Found"}
#: Names of attributes, if different from documents.
ATTRIBUTES = {("Loop", "loop"): "name", ("Loop", "type"): "loop_type", ("Loop", "detectors"): "findings"}
#: Lists of named items, which become dictionaries by name.
TYPES = {("Loop", "detectors"): "dict[str, Finding]", ("Loop", "kpis"): "dict[str, Kpi]"}
#: Attributes that unpack first, because they are used most.
FIRST = {"Loop": ["loop", "type", "verdict", "stiction", "oscillation"], "Stiction": ["S", "J", "coverage"]}
#: Fields that are not attributes, with the reason.
LEFT_OUT = {
    # `Diagnosis` has more details of the evidence, and the recording instead of its source.
    ("Loop", "source"): "",
    ("Loop", "evidence"): "",
    ("Verdict", "override"): "the command keeps the conclusions of people",
}

Function = (ast.FunctionDef, ast.AsyncFunctionDef)


def rust_documentation() -> dict[str, str]:
    """Documentation of compiled classes, by name, and of their methods, by `Class.name`."""
    found: dict[str, str] = {}
    for path in sorted(COMPILED.glob("*.rs")):
        lines: list[str] = []
        owner = ""
        compiled = ""
        called: dict[str, str] = {}
        for line in path.read_text().splitlines():
            text = line.strip()
            if text.startswith("///"):
                lines.append(text[3:].removeprefix(" "))
                continue
            if text.startswith("#["):
                compiled = text if text.startswith("#[pyclass") else compiled
                continue
            if match := re.match(r"impl (\w+) \{", text):
                owner = called.get(match[1], match[1])
            elif lines and compiled and (match := re.match(r"pub(?:\(crate\))? (?:struct|enum) (\w+)", text)):
                # It may have another name in Python.
                given = re.search(r'name = "(\w+)"', compiled)
                called[match[1]] = given[1] if given else match[1]
                found[called[match[1]]] = "\n".join(lines)
            elif lines and (match := re.match(r"(?:pub )?fn (\w+)", text)):
                found[f"{owner}.{match[1]}"] = "\n".join(lines)
            lines, compiled = [], ""
    return found


def first(text: str) -> str:
    """The first sentence of a doc string, as a cell of a table."""
    paragraph = " ".join(text.strip().partition("\n\n")[0].split())
    sentence = re.split(r"(?<=\.) (?=[A-Z`])", re.sub(r"``([^`]+)``", r"`\1`", paragraph))[0]
    return sentence.replace("|", "\\|")


def parameters(function: ast.FunctionDef | ast.AsyncFunctionDef, method: bool = False) -> str:
    """The parameters of a function, optional ones in brackets, and what it returns."""
    of = function.args
    plain = [*of.posonlyargs, *of.args][method:]
    required = len(plain) - len(of.defaults)
    said = [each.arg for each in plain[:required]]
    left_out = [each.arg for each in plain[required:]]
    said += [f"*{of.vararg.arg}"] if of.vararg else []
    named = [each.arg for each, default in zip(of.kwonlyargs, of.kw_defaults) if default is None]
    free = [each.arg for each, default in zip(of.kwonlyargs, of.kw_defaults) if default is not None]
    said += ["*", *named] if named else []
    left_out += ["*"] if free and not named and not of.vararg else []
    left_out += free + ([f"**{of.kwarg.arg}"] if of.kwarg else [])
    whole = ", ".join(said)
    whole += f"[{', ' if said else ''}{', '.join(left_out)}]" if left_out else ""
    returns = f" -> {ast.unparse(function.returns)}" if function.returns and not method else ""
    return f"`({whole}){returns}`".replace("|", "\\|")


def kind_of(field: dict[str, Any]) -> str:
    """The Python type of a field of the schema."""
    if "$ref" in field:
        name = field["$ref"].rpartition("/")[2]
        return CALLED.get(name, name)
    if "anyOf" in field:
        return " | ".join(map(kind_of, field["anyOf"]))
    if isinstance(field["type"], list):
        return " | ".join(kind_of({**field, "type": each}) for each in field["type"])
    if field["type"] == "array":
        return f"list[{kind_of(field['items'])}]"
    return {"number": "float", "integer": "int", "string": "str", "boolean": "bool", "null": "None"}[field["type"]]


def attribute(name: str, kind: str, said: str) -> str:
    """The source line of an attribute of a result, with its description."""
    quote = "'" if '"' in said else '"'
    one = f"    {name}: {kind} = about({quote}{said}{quote})"
    if len(one) <= 120:
        return one
    lines = textwrap.wrap(said, 109, break_on_hyphens=False)
    inside = f" {quote}\n        {quote}".join(lines)
    return f"    {name}: {kind} = about(\n        {quote}{inside}{quote}\n    )"


def classes() -> str:
    """The module of the classes of a diagnosis."""
    schemas = {of: schema for of, schema in json.loads(SCHEMA.read_text())["$defs"].items() if of not in ELSEWHERE}
    names = sorted(CALLED.get(of, of) for of in schemas)
    parts = [CLASSES_HEAD + "".join(f'    "{name}",\n' for name in names if name != "Found") + "]\n"]
    for of, schema in schemas.items():
        about = textwrap.wrap(spoken(schema), 110)
        doc = [f'    """{about[0]}', *(f"    {line}" for line in about[1:]), *(['    """'] if about[1:] else [])]
        doc[-1] += "" if about[1:] else '"""'
        lines = ["@result", f"class {CALLED.get(of, of)}(Result):", *doc, ""]
        documented_as, left_out = {}, {}
        fields = schema["properties"]
        for name in dict.fromkeys([*FIRST.get(of, []), *fields]):
            field = fields[name]
            if (of, name) in LEFT_OUT:
                left_out |= {name: why} if (why := LEFT_OUT[of, name]) else {}
                continue
            called = ATTRIBUTES.get((of, name), f"{name}_" if keyword.iskeyword(name) else name)
            if called.rstrip("_") != name:
                documented_as[called] = name
            lines.append(attribute(called, TYPES.get((of, name)) or kind_of(field), spoken(field)))
        for name, held in (("_documented_as", documented_as), ("_left_out", left_out)):
            if held:
                entries = "".join(f"        {json.dumps(key)}: {json.dumps(value)},\n" for key, value in held.items())
                lines.append(f"\n    {name}: ClassVar[Mapping[str, str]] = {{\n{entries}    }}")
        parts.append("\n".join(lines) + "\n")
    return "\n\n".join(parts)


def spoken(schema: dict[str, Any]) -> str:
    """The description in a schema, in Python's terms."""
    return re.sub(r"\bnull\b", "None", " ".join(schema["description"].split()))


def held(bodies: list[list[ast.stmt]], rust: dict[str, str], name: str) -> Iterator[str]:
    """The attributes and methods of a class, by name."""
    attributes: dict[str, None] = {}
    methods: dict[str, None] = {}
    for each in (each for body in bodies for each in body):
        match each:
            case ast.AnnAssign(ast.Name(own), annotation) if own[0] != "_" and "ClassVar" not in ast.unparse(annotation):
                attributes[own] = None
            case ast.FunctionDef(own) | ast.AsyncFunctionDef(own) if own[0] != "_":
                if ast.get_docstring(each) or f"{name}.{own}" in rust or each.decorator_list:
                    kinds = " ".join(map(ast.unparse, each.decorator_list))
                    (attributes if "property" in kinds or ".setter" in kinds else methods)[own] = None
    for kind, names in (("Attribute", attributes), ("Method", methods)):
        if names:
            yield f"{kind}{'s' if len(names) > 1 else ''} {', '.join(f'`{own}`' for own in names)}."


def row(name: str, said: str, *words: str) -> str:
    """A row of the table of a module, without a head, so that the search of the pages finds its name."""
    return f"| `{name}` | {said} | {' '.join(words)} |"


def of_class(name: str, of: ast.ClassDef, rust: dict[str, str], others: dict[str, ast.ClassDef]) -> str:
    """The row of a class."""
    bases = [ast.unparse(base).removeprefix("_core.") for base in of.bases]
    bodies = [*(others[base].body for base in bases if base in others and others[base] is not of), of.body]
    makers = [each for body in bodies for each in body if isinstance(each, Function) and each.name in {"__init__", "__new__"}]
    said = re.sub(r" -> .*`", "`", parameters(makers[-1], method=True)) if makers else ""
    return row(name, said, first(ast.get_docstring(of) or rust[name]), *held(bodies, rust, name))


def public(module: ast.Module) -> list[str]:
    """The public names of a module, in order."""
    names: list[str] = []
    for each in module.body:
        match each:
            case ast.Assign([ast.Name("__all__")], value):
                names = ast.literal_eval(value)
            case ast.AugAssign(ast.Name("__all__"), value=ast.Attribute(ast.Name("_document"))):
                names = sorted([*names, *public(ast.parse(CLASSES.read_text()))])
    return names


def modules() -> list[tuple[str, Path]]:
    """Modules with their names relative to the package, and their files. A package is a module, too."""
    found = []
    for path in PACKAGE.rglob("*.py"):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        if parts[-1] == "__init__" and len(parts) > 1:
            parts = parts[:-1]
        if not any(part.startswith("_") for part in parts):
            found.append((".".join(parts), path))
    return sorted(found)


def top() -> list[str]:
    """The functions and classes of `stiction` itself."""
    imports = [each for each in ast.parse((PACKAGE / "__init__.py").read_text()).body if isinstance(each, ast.ImportFrom)]
    names = {each.name for of in imports if of.module != "stiction" for each in of.names}
    return sorted((name for name in names if name[0] != "_"), key=str.lower)


def page() -> str:
    """The whole page."""
    rust = rust_documentation()
    stub = ast.parse((PACKAGE / "_core.pyi").read_text())
    made = ast.parse(CLASSES.read_text())
    others = {each.name: each for of in (stub, made) for each in of.body if isinstance(each, ast.ClassDef)}
    names = ", ".join(f"`{name}`" for name in top())
    parts = [HEAD.strip().format(top=textwrap.fill(f"These names are in `stiction` itself, too: {names}.", 130))]
    for called, path in modules():
        module = ast.parse(path.read_text())
        # A package takes some of its names from its modules.
        files = [*path.parent.glob("*.py"), path] if path.stem == "__init__" else [path]
        bodies = [each for file in files for each in ast.parse(file.read_text()).body]
        own = {each.name: each for each in bodies if isinstance(each, (*Function, ast.ClassDef))}
        rows = ["| | | |", "|---|---|---|"]
        for name in public(module):
            match own.get(name) or others.get(name):
                case ast.ClassDef() as of:
                    rows.append(of_class(name, of, rust, others))
                case ast.FunctionDef() | ast.AsyncFunctionDef() as function:
                    rows.append(row(name, parameters(function), first(ast.get_docstring(function) or "")))
                case _:
                    rows.append(row(name, "", constant(module, name) or constant(stub, name)))
        if rows[2:]:
            parts += [f"## stiction.{called}", first(ast.get_docstring(module) or ""), "\n".join(rows)]
    return "\n\n".join(parts) + "\n"


def constant(module: ast.Module, name: str) -> str:
    """The first sentence of the doc string below a value."""
    for each, after in zip(module.body, module.body[1:]):
        target = getattr(each, "target", None) or next(iter(getattr(each, "targets", [])), None)
        if isinstance(target, ast.Name) and target.id == name:
            match after:
                case ast.Expr(ast.Constant(str(text))):
                    return first(text)
    return ""


def main() -> None:
    # The page also includes the classes.
    for path, made in ((CLASSES, classes), (PAGE, page)):
        text = made()
        if path.exists() and path.read_text() == text:
            print(f"{path.name} is up to date", file=sys.stderr)
        path.write_text(text)


if __name__ == "__main__":
    main()
