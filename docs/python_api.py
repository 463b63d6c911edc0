"""Writes `python/stiction/_document.py`, the classes of a diagnosis from its schema, and `docs/python-api.md`, every public
name of the Python package with its signature and its documentation.

python3 docs/python_api.py

It reads the sources and runs only `_words.py`, so the package need not be installed. Signatures come from the modules and
from `_core.pyi`. Documentation comes from doc strings and attributes and, for compiled classes, from the Rust files.
"""

from __future__ import annotations

import ast
import importlib.util
import inspect
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

Made by `python3 docs/python_api.py` and checked by a test. The names of most modules are available directly in `stiction`, such as
`stiction.diagnose`. The names of `stiction.bench`, `stiction.control`, `stiction.datasets`, `stiction.fmu`, `stiction.pandas`,
`stiction.live`, `stiction.plant`, `stiction.sklearn` and `stiction.valve_test` stay in their modules. Every result unpacks in the order of its
attributes, and has `to_dict()`.
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
#: Sections of a doc string that list names.
LISTS = {"Parameters", "Returns", "Raises", "Attributes", "Yields", "Warns"}

_spec = importlib.util.spec_from_file_location("_words", PACKAGE / "_words.py")
assert _spec and _spec.loader
words = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(words)

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


def plain(text: str) -> str:
    """A paragraph of a doc string in one line, with code in Markdown."""
    return re.sub(r"``([^`]+)``", r"`\1`", " ".join(text.split()))


def listed(lines: list[str]) -> Iterator[str]:
    """Names with their descriptions, as a list."""
    entries: list[tuple[str, list[str]]] = []
    for line in lines:
        if line and not line[0].isspace():
            entries.append((line, []))
        elif entries:
            entries[-1][1].append(line)
    for name, about in entries:
        name, _, kind = name.partition(" : ")
        words = plain("\n".join(about))
        yield f"* `{name}`" + (f" ({plain(kind)})" if kind else "") + (f": {words}" if words else "")


def prose(lines: list[str]) -> Iterator[str]:
    """Paragraphs, and examples as code."""
    for paragraph in re.split(r"\n\s*\n", "\n".join(lines).strip()):
        if paragraph.lstrip().startswith(">>>"):
            yield f"```pycon\n{inspect.cleandoc(paragraph)}\n```"
        elif paragraph:
            yield plain(paragraph)


def documentation(text: str) -> Iterator[str]:
    """A doc string as Markdown."""
    lines = inspect.cleandoc(text).splitlines()
    starts = [k - 1 for k, line in enumerate(lines) if k and re.fullmatch(r"-{3,}", line)]
    yield from prose(lines[: starts[0]] if starts else lines)
    for start, end in zip(starts, [*starts[1:], len(lines)]):
        name, body = lines[start], lines[start + 2 : end]
        yield f"**{name}**"
        if name in LISTS:
            yield "\n".join(listed(body))
        else:
            yield from prose(body)


def signature(name: str, function: ast.FunctionDef | ast.AsyncFunctionDef, method: bool) -> str:
    """The signature of a function."""
    arguments = ast.parse(ast.unparse(function)).body[0].args  # type: ignore[attr-defined]
    static = any(ast.unparse(each) == "staticmethod" for each in function.decorator_list)
    if method and not static:
        (arguments.posonlyargs or arguments.args).pop(0)
    returns = f" -> {ast.unparse(function.returns)}" if function.returns and function.name != "__new__" else ""
    whole = f"{name}({ast.unparse(arguments)}){returns}"
    if len(whole) <= 100:
        return whole
    # One line per argument if they do not fit on one line.
    parts = re.split(r", (?![^\[(]*[\])])", ast.unparse(arguments))
    return f"{name}(\n" + "".join(f"    {part},\n" for part in parts) + f"){returns}"


def code(text: str) -> str:
    """A signature as a code block that is not run."""
    return f"```py\n{text}\n```"


def of_callable(function: ast.FunctionDef | ast.AsyncFunctionDef) -> str:
    """The doc string of a function, completed by its decorators."""
    text = ast.get_docstring(function) or ""
    arguments = function.args
    names = [each.arg for each in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]
    for decorator in function.decorator_list:
        match decorator:
            case ast.Name("documented"):
                text = words.completed(text, names)
            case ast.Call(ast.Name("drawn"), [ast.Constant(count)]):
                text = words.plotting(text, count)
    return text


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


def of_result(of: ast.ClassDef, known: dict[str, ast.ClassDef]) -> str:
    """The doc string of a class, with its attributes if it is a result."""
    text = ast.get_docstring(of) or ""
    if "result" not in map(ast.unparse, of.decorator_list):
        return text
    inherited = [known[name].body for base in of.bases if (name := ast.unparse(base)) in known]
    fields = []
    for each in [*(each for body in inherited for each in body), *of.body]:
        match each:
            case ast.AnnAssign(ast.Name(name), annotation, ast.Call(ast.Name("about"), [ast.Constant(said)], more)):
                kind = {keyword.arg: keyword.value for keyword in more}.get("kind", ast.Constant(""))
                fields.append((name, ast.unparse(annotation), said, ast.literal_eval(kind)))
            case ast.AnnAssign(ast.Name(name), annotation) if "ClassVar" not in ast.unparse(annotation):
                fields.append((name, ast.unparse(annotation), "", ""))
    return str(words.with_attributes(text, fields))


def of_function(name: str, function: ast.FunctionDef | ast.AsyncFunctionDef, level: str) -> Iterator[str]:
    yield f"{level} {name}"
    yield code(signature(name, function, method=False))
    yield from documentation(of_callable(function))


def of_class(name: str, of: ast.ClassDef, rust: dict[str, str], known: dict[str, ast.ClassDef]) -> Iterator[str]:
    bases = [ast.unparse(base) for base in of.bases if ast.unparse(base) not in {"Result", "Protocol", *known}]
    makers = [each for each in of.body if isinstance(each, Function) and each.name in {"__init__", "__new__"}]
    yield f"### {name}"
    if makers:
        yield code(signature(f"class {name}", makers[0], method=True).removesuffix(" -> None"))
    else:
        yield code(f"class {name}({', '.join(bases)})" if bases else f"class {name}")
    yield from documentation(of_result(of, known) or rust.get(name, ""))
    for each in of.body:
        if not isinstance(each, Function) or each.name.startswith("_"):
            continue
        text = of_callable(each) or rust.get(f"{name}.{each.name}", "")
        decorators = {ast.unparse(decorator) for decorator in each.decorator_list}
        if not text or any(decorator.endswith(".setter") for decorator in decorators):
            continue
        yield f"#### {name}.{each.name}"
        if decorators & {"property", "cached_property", "functools.cached_property"}:
            kind = f": {ast.unparse(each.returns)}" if each.returns else ""
            yield code(f"{name}.{each.name}{kind}")
        else:
            yield code(signature(f"{name}.{each.name}", each, method=True))
        yield from documentation(text)


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


def page() -> str:
    """The whole page."""
    rust = rust_documentation()
    stub = ast.parse((PACKAGE / "_core.pyi").read_text())
    compiled = {each.name: each for each in stub.body if isinstance(each, ast.ClassDef)}
    made = {each.name: each for each in ast.parse(CLASSES.read_text()).body if isinstance(each, ast.ClassDef)}
    parts = [HEAD.strip()]
    for called, path in modules():
        module = ast.parse(path.read_text())
        names = public(module)
        if not names:
            continue
        parts.append(f"## stiction.{called}")
        parts.extend(documentation(ast.get_docstring(module) or ""))
        own = {each.name: each for each in module.body if isinstance(each, (*Function, ast.ClassDef))}
        for name in names:
            match own.get(name) or made.get(name) or compiled.get(name):
                case ast.ClassDef() as of:
                    parts.extend(of_class(name, of, rust, made))
                case ast.FunctionDef() | ast.AsyncFunctionDef() as function:
                    parts.extend(of_function(name, function, "###"))
                case _:
                    parts.append(f"### {name}")
                    parts.extend(constant(module, name) or constant(stub, name))
    return "\n\n".join(parts) + "\n"


def constant(module: ast.Module, name: str) -> list[str]:
    """A value's type and the doc string below it."""
    for each, after in zip(module.body, [*module.body[1:], None]):
        target = getattr(each, "target", None) or next(iter(getattr(each, "targets", [])), None)
        if isinstance(target, ast.Name) and target.id == name:
            kind = [code(ast.unparse(each))] if isinstance(each, ast.AnnAssign) else []
            text = after.value.value if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) else ""
            return [*kind, *documentation(str(text))]
    return []


def main() -> None:
    # The page also includes the classes.
    for path, made in ((CLASSES, classes), (PAGE, page)):
        text = made()
        if path.exists() and path.read_text() == text:
            print(f"{path.name} is up to date", file=sys.stderr)
        path.write_text(text)


if __name__ == "__main__":
    main()
