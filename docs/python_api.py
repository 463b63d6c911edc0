"""Writes `docs/python-api.md`: every public name of the Python package, with its signature and its documentation.

python3 docs/python_api.py

It reads the sources and runs none but `_words.py`, so that the package need not be installed: signatures stand in the
modules and in `_core.pyi`, documentation in their doc strings, beside attributes and, of compiled classes, in the Rust
files.
"""

from __future__ import annotations

import ast
import importlib.util
import inspect
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "python" / "stiction"
COMPILED = ROOT / "crates" / "stiction-python" / "src"
PAGE = ROOT / "docs" / "python-api.md"
HEAD = """# Python API

Made by `python3 docs/python_api.py`; a test compares. Names of most modules are those of `stiction` itself:
`stiction.diagnose`. Those of `stiction.control`, `stiction.datasets`, `stiction.fmu`, `stiction.pandas`, `stiction.plant`
and `stiction.sklearn` stay in their module. Every result unpacks in the order of its attributes, and has `to_dict()`.
"""
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
                # In Python it may have a name of its own.
                given = re.search(r'name = "(\w+)"', compiled)
                called[match[1]] = given[1] if given else match[1]
                found[called[match[1]]] = "\n".join(lines)
            elif lines and (match := re.match(r"(?:pub )?fn (\w+)", text)):
                found[f"{owner}.{match[1]}"] = "\n".join(lines)
            lines, compiled = [], ""
    return found


def plain(text: str) -> str:
    """A paragraph of a doc string in one line, with code as Markdown has it."""
    return re.sub(r"``([^`]+)``", r"`\1`", " ".join(text.split()))


def listed(lines: list[str]) -> Iterator[str]:
    """Names with what they are, as a list."""
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
    """A function as it is called."""
    arguments = ast.parse(ast.unparse(function)).body[0].args  # type: ignore[attr-defined]
    static = any(ast.unparse(each) == "staticmethod" for each in function.decorator_list)
    if method and not static:
        (arguments.posonlyargs or arguments.args).pop(0)
    returns = f" -> {ast.unparse(function.returns)}" if function.returns and function.name != "__new__" else ""
    whole = f"{name}({ast.unparse(arguments)}){returns}"
    if len(whole) <= 100:
        return whole
    # A line an argument, where one line does not hold them.
    parts = re.split(r", (?![^\[(]*[\])])", ast.unparse(arguments))
    return f"{name}(\n" + "".join(f"    {part},\n" for part in parts) + f"){returns}"


def code(text: str) -> str:
    """A signature: Python to be read, none to be run."""
    return f"```py\n{text}\n```"


def of_callable(function: ast.FunctionDef | ast.AsyncFunctionDef) -> str:
    """The doc string of a function, as its decorators complete it."""
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


def of_result(of: ast.ClassDef) -> str:
    """The doc string of a class, with its attributes if it is a result."""
    text = ast.get_docstring(of) or ""
    if "result" not in map(ast.unparse, of.decorator_list):
        return text
    fields = []
    for each in of.body:
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


def of_class(name: str, of: ast.ClassDef, rust: dict[str, str]) -> Iterator[str]:
    bases = [ast.unparse(base) for base in of.bases if ast.unparse(base) not in {"Result", "Protocol"}]
    makers = [each for each in of.body if isinstance(each, Function) and each.name in {"__init__", "__new__"}]
    yield f"### {name}"
    if makers:
        yield code(signature(f"class {name}", makers[0], method=True).removesuffix(" -> None"))
    else:
        yield code(f"class {name}({', '.join(bases)})" if bases else f"class {name}")
    yield from documentation(of_result(of) or rust.get(name, ""))
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
    """The names that a module offers, in its order."""
    for each in module.body:
        if isinstance(each, ast.Assign) and [ast.unparse(target) for target in each.targets] == ["__all__"]:
            return list(ast.literal_eval(each.value))
    return []


def modules() -> list[tuple[str, Path]]:
    """Modules by their names from the package on, and their files; a package is a module, too."""
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
            match own.get(name) or compiled.get(name):
                case ast.ClassDef() as of:
                    parts.extend(of_class(name, of, rust))
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
    text = page()
    if PAGE.exists() and PAGE.read_text() == text:
        print(f"{PAGE.name} is as it should be", file=sys.stderr)
    PAGE.write_text(text)


if __name__ == "__main__":
    main()
