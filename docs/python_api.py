"""Writes `python/stiction/_document.py`, classes of results from their schemas; the functions in `_core.pyi`; and
`docs/python-api.md`, every public name of the Python package with its parameters and the first sentence of its documentation.

python3 docs/python_api.py

The schemas come from the installed `stiction._core`. Everything else is read from the sources: parameters from the modules and
`_core.pyi`, documentation from doc strings and, for compiled classes, from the Rust files.
"""

from __future__ import annotations

import ast
import importlib.util
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
COMPILED = ROOT / "addons" / "stiction-python" / "src"
PAGE = ROOT / "docs" / "python-api.md"
CLASSES = PACKAGE / "_document.py"
STUB = PACKAGE / "_core.pyi"
MADE = "# Handles and functions, made by `python3 docs/python_api.py` from the Rust files."
#: Python types of Rust types without arguments. Others that are no class of the stub are `Any`.
PLAIN = {
    "f64": "float",
    **dict.fromkeys(["i64", "u8", "u32", "u64", "usize"], "int"),
    **dict.fromkeys(["str", "String"], "str"),
    **dict.fromkeys(["In", "Out", "Signal"], "_Array"),
    "ArrowTable": "Table",
    "PathBuf": "str | Path",
    "PyDict": "dict[str, Any]",
    "PyMapping": "Mapping[str, Any]",
    "bool": "bool",
}
HEAD = """# Python API

This page lists the names of every module, with parameters, result and the first sentence of the documentation. Parameters in
brackets are optional, and parameters after `*` are given by name. The docstrings describe parameters, equations, results and
errors, with examples. `help` prints a docstring, as in `help(stiction.cycles.limit_cycle)`.

{top}

Every result unpacks in the order of its attributes, and has `to_dict()`. `python3 docs/python_api.py` makes this page, and a test
checks it.
"""
CLASSES_HEAD = '''"""Results, with the descriptions of their JSON schemas.

Made by `python3 docs/python_api.py` from the schemas of the compiled module, and checked by a test.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from stiction._result import Result, about, result
from stiction.detection import Finding

__all__ = [
'''
#: Schemas without a class: Python has more of `Finding` and `Fit`, and the others are within classes in another form.
ELSEWHERE = {"Finding", "Line", "Weighing", "Kpis", "Override", "Source", "Fit", "Comparison"}
#: Names of classes, if different from the schema.
CALLED = {
    "Cycle": "FittedCycle",
    "GridRepair": "Mended",
    "LawEntry": "FrictionLaw",
    "Loop": "Found",
    "Manifest": "Scanned",
    "ModelEntry": "FmuModel",
    "Number": "Parameter",
    "Predicted": "PredictedSwing",
    "Prospects": "RankedProspects",
    "Repair": "RepairEffect",
    "Resting": "OperatingPoint",
    "Signature": "SignatureReading",
    "Supervised": "Supervision",
    "Swing": "RecordedSwing",
    "Variable": "FmuVariable",
}
#: Classes of a diagnosis that are public in other modules, or only a base.
NOT_OF_DIAGNOSIS = {"Episode", "Fitness", "Found", "Measure", "Oscillation", "Parameter", "Peak", "Supervision"}
#: Names of attributes, if different from documents.
ATTRIBUTES = {
    ("History", "windows"): "observations",
    ("Loop", "detectors"): "findings",
    ("Loop", "loop"): "name",
    ("Loop", "type"): "loop_type",
    ("ModelEntry", "law"): "name",
    ("ModelEntry", "model"): "kind",
    ("Proposal", "Ms"): "ms",
}
#: Types of attributes that the schema does not give: lists of named items, which become dictionaries by name, and pairs.
TYPES = {
    ("Loop", "detectors"): "dict[str, Finding]",
    ("Loop", "kpis"): "dict[str, Kpi]",
    ("Number", "value"): "float",
    ("Peak", "band"): "tuple[float, float]",
    ("Variable", "start"): "float | bool | None",
}
#: Types in docstrings, if more is known.
KINDS = {
    ("FittedController", "structure"): '{"P", "PI", "PID"}',
    ("FittedProcess", "kind"): '{"self-regulating", "integrating"}',
    ("Fitness", "class"): '{"fit", "caveats", "unfit"}',
    ("LoopThere", "op_range"): "list of two floats or None",
    ("Measure", "class"): '{"fit", "caveats", "unfit"}',
    ("Oscillation", "basis"): '{"autocorrelation", "spectral peak"} or None',
    ("Repair", "outcome"): '{"worked", "helped", "no change", "worse", "cannot tell"}',
    ("Variable", "start"): "float or int or bool or None",
}
#: Descriptions of classes for users of Python, who do not see the module of the Rust type.
SAID = {"PositionReading": "Results from the stem position, by the definitions of ANSI/ISA-75.25.01 (recalled)."}
#: Attributes that unpack first, because they are used most or were first.
FIRST = {
    "Observation": ["time_s", "class", "probability", "S", "J", "weight", "windows", "grade", "pool"],
    "Loop": ["loop", "type", "verdict", "stiction", "oscillation"],
    "Repair": ["time_s", "outcome", "words"],
    "Stiction": ["S", "J", "coverage"],
}
#: Values of attributes that need not be given.
DEFAULTS = {
    ("Observation", "weight"): 1.0,
    ("Observation", "windows"): 1.0,
    **{("Observation", name): None for name in ("probability", "S", "J", "grade", "pool")},
}
#: Fields that are not attributes, with the reason.
LEFT_OUT = {
    # `Diagnosis` has more details of the evidence, and the recording instead of its source.
    ("Loop", "source"): "",
    ("Loop", "evidence"): "",
    # `Diagnosis` has it as `oscillating_signal`.
    ("Oscillation", "signal"): "",
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


def split(text: str) -> list[str]:
    """Return the parts of a text between commas outside brackets."""
    parts, depth = [""], 0
    for each in text:
        depth += (each in "(<[") - (each in ")>]")
        parts = [*parts, ""] if each == "," and not depth else [*parts[:-1], parts[-1] + each]
    return [part.strip() for part in parts if part.strip()]


def typed(rust: str, many: str, classes: set[str]) -> str:
    """The Python type of a Rust type, with `many` for lists."""
    rust = re.sub(r"'\w+(, | )?|&", "", rust).strip()
    if rust == "[u8]":
        return "bytes"
    if rust[:1] in {"(", "["}:
        inside = [typed(each, many, classes) for each in split(rust[1:-1].partition(";")[0])]
        return f"tuple[{', '.join(inside)}]" if rust[0] == "(" else f"{many}[{inside[0]}]"
    outer, _, inside = rust.removesuffix(">").partition("<")
    outer = outer.rpartition("::")[2]
    match outer:
        case "Option":
            return f"{typed(inside, many, classes)} | None".replace("Any | None", "Any")
        case "Vec" if inside == "f64" and many == "Sequence":
            return "Sequence[float] | _Array"
        case "Vec":
            return f"{many}[{typed(inside, many, classes)}]"
        case "BTreeSet":
            return f"set[{typed(inside, many, classes)}]"
        case "PyArray1" | "PyReadonlyArray1":
            return "_Array" if inside == "f64" else f"npt.NDArray[np.{inside.lower().replace('64', '128')}]"
        case "Bound" | "Py" | "PyRef" | "PyResult":
            return typed(inside, many, classes) if inside != "()" else "None"
        case _:
            return PLAIN.get(outer) or (outer if outer in classes else "Any")


def stub() -> str:
    """Return the stub of the compiled module, with unchanged public classes, and with handles and functions from the Rust files."""
    text = STUB.read_text().partition(MADE)[0]
    files = [path.read_text() for path in sorted(COMPILED.glob("*.rs"))]
    handles = re.findall(r'#\[pyclass\([^\n]*module = "stiction\._core"(?:[^{;]*?)pub struct (\w+)', "\n".join(files))
    classes = {each.name for each in ast.parse(text).body if isinstance(each, ast.ClassDef)} | {*handles}

    def line(owner: str, attributes: str, name: str, inside: str, returns: str) -> str:
        """The stub of a function, or of a method of an owner."""
        default = dict(re.findall(r"(\w+) = (None)", attributes))
        told = [each.partition(": ")[::2] for each in split(" ".join(inside.split())) if "Python<" not in each]
        said = [
            f"{called}: {typed(kind, 'Sequence', classes)}" + (f" = {default[called]}" if called in default else "")
            for called, kind in told
            if kind
        ]
        new = "#[new]" in attributes
        given = owner if new else typed(" ".join(returns.split()), "list", classes) if returns else "None"
        words = f"def {'__new__' if new else name}({', '.join((['cls'] if new else ['self'] if owner else []) + said)})"
        property = "    @property\n" if "#[getter]" in attributes else ""
        return f"{property}{'    ' if owner else ''}{words} -> {given}: ..."

    head = r"((?:{0}#[^\n]*\n)*){0}(?:pub )?fn (\w+)[^(]*\((.*?)\)(?: -> ([^{{]*?))? \{{\n"
    lines = [MADE]
    for file in files:
        for owner, body in re.findall(r"#\[pymethods\]\nimpl (\w+) \{\n(.*?)\n\}\n", file, re.DOTALL):
            if owner in handles:
                methods = re.findall(head.format("    "), body, re.DOTALL)
                known = [each for each in methods if each[1][:2] != "__" or each[1] == "__len__"]
                lines += ["@final", f"class {owner}:", *(line(owner, *each) for each in known)]
        lines += [line("", *each) for each in re.findall(r"#\[pyfunction\]\n" + head.format(""), file, re.DOTALL)]
    return text + "\n".join(lines) + "\n"


def first(text: str) -> str:
    """The first sentence of a doc string, as a cell of a table."""
    paragraph = " ".join(text.strip().partition("\n\n")[0].split())
    sentence = re.split(r"(?<=\.) (?=[A-Z`])", re.sub(r"``([^`]+)``", r"`\1`", paragraph))[0]
    return sentence.replace("|", "\\|")


def parameters(function: ast.FunctionDef | ast.AsyncFunctionDef, method: bool = False) -> str:
    """Return the parameters of a function, with optional parameters in brackets, and the type of its result."""
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


def schemas() -> dict[str, Any]:
    """The schemas of results by name. The module is loaded without the package, which needs the classes that are made here."""
    core = sys.modules.get("stiction._core")
    if core is None:
        [folder] = importlib.util.find_spec("stiction").submodule_search_locations
        spec = importlib.util.spec_from_file_location("stiction._core", next(Path(folder).glob("_core*[!i]")))
        core = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(core)
    return json.loads(core.result_schemas())["$defs"]


def kind_of(field: dict[str, Any], known: dict[str, Any]) -> str:
    """The Python type of a field of a schema."""
    if "$ref" in field:
        name = field["$ref"].rpartition("/")[2]
        # Without properties it is the name of a case.
        return CALLED.get(name, name) if "properties" in known[name] else "str"
    if "anyOf" in field:
        return " | ".join(kind_of(each, known) for each in field["anyOf"])
    if isinstance(field["type"], list):
        return " | ".join(kind_of({**field, "type": each}, known) for each in field["type"])
    if field["type"] == "array":
        return f"list[{kind_of(field['items'], known)}]"
    return {"number": "float", "integer": "int", "string": "str", "boolean": "bool", "null": "None"}[field["type"]]


def cases(field: dict[str, Any], known: dict[str, Any]) -> str:
    """Return the values of a field with named cases, in the notation of docstrings."""
    own = known.get(field.get("$ref", "").rpartition("/")[2], {}).get("oneOf", [])
    return "{" + ", ".join(json.dumps(each["const"]) for each in own) + "}" if own else ""


def within(name: str, known: dict[str, Any]) -> set[str]:
    """Return the names of a schema and of all schemas within it."""
    found, waiting = set(), [name]
    while waiting:
        if (of := waiting.pop()) not in found:
            found.add(of)
            waiting += re.findall(r'"#/\$defs/(\w+)"', json.dumps(known[of]))
    return found


def attribute(name: str, kind: str, said: str, shown: str) -> str:
    """The source line of an attribute of a result, with its description and further arguments."""
    quote = "'" if '"' in said else '"'
    one = f"    {name}: {kind} = about({quote}{said}{quote}{shown})"
    if len(one) <= 120:
        return one
    lines = textwrap.wrap(said, 109, break_on_hyphens=False)
    inside = f" {quote}\n        {quote}".join(lines)
    return f"    {name}: {kind} = about(\n        {quote}{inside}{quote}{shown}\n    )"


def classes() -> str:
    """The module of the classes that are made from schemas."""
    known = schemas()
    made = {of: schema for of, schema in known.items() if of not in ELSEWHERE and "properties" in schema}
    names = {CALLED.get(of, of) for of in within("Loop", known) & made.keys()} - NOT_OF_DIAGNOSIS
    parts = [CLASSES_HEAD + "".join(f'    "{name}",\n' for name in sorted(names)) + "]\n"]
    for of, schema in made.items():
        about = textwrap.wrap(SAID.get(of) or spoken(schema), 110)
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
            kind = TYPES.get((of, name)) or kind_of(field, known)
            shown = KINDS.get((of, name)) or cases(field, known)
            more = f", kind={shown!r}" if shown else ""
            more += f", default={DEFAULTS[of, name]!r}" if (of, name) in DEFAULTS else ""
            lines.append(attribute(called, kind, spoken(field), more))
        for name, held in (("_documented_as", documented_as), ("_left_out", left_out)):
            if held:
                entries = "".join(f"        {json.dumps(key)}: {json.dumps(value)},\n" for key, value in held.items())
                lines.append(f"\n    {name}: ClassVar[Mapping[str, str]] = {{\n{entries}    }}")
        parts.append("\n".join(lines) + "\n")
    return "\n\n".join(parts)


def spoken(schema: dict[str, Any]) -> str:
    """Return the description in a schema, with the words of Python."""
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
    stub = ast.parse(STUB.read_text())
    made = ast.parse(CLASSES.read_text())
    everything = [*(ast.parse(path.read_text()) for _, path in modules()), stub, made]
    others = {each.name: each for of in everything for each in of.body if isinstance(each, ast.ClassDef)}
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
    for path, made in ((CLASSES, classes), (STUB, stub), (PAGE, page)):
        text = made()
        if path.exists() and path.read_text() == text:
            print(f"{path.name} is up to date", file=sys.stderr)
        path.write_text(text)


if __name__ == "__main__":
    main()
