"""Write the bill of materials of a product, with every linked crate, as CycloneDX 1.5 JSON.

    python3 supply/sbom.py stiction-cli > stiction.cdx.json
    python3 supply/sbom.py stiction-python --wheel dist/stiction-*.whl

With `--wheel` the bill is added to the wheel in `*.dist-info/sboms/`, as PEP 770 requires. It is made from the lock
file and from the crates that Cargo would build for a target (`--target`, by default this machine's). Crates that are
used only for the build, such as macros, are not in the bill. The same sources give the same bytes, because the bill
contains no time, path or random number. The script needs Cargo and only Python's standard library.
"""

from __future__ import annotations

import argparse
import base64
import hashlib
import json
import pathlib
import re
import subprocess
import tomllib
import zipfile
from typing import Any

ROOT = pathlib.Path(__file__).resolve().parents[1]
BILL = "stiction.cdx.json"


def cargo(*arguments: str) -> str:
    """Return the output of Cargo."""
    command = ["cargo", *arguments, "--locked"]
    return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def host() -> str:
    """Return the default target of Cargo."""
    told = subprocess.run(["rustc", "-vV"], check=True, stdout=subprocess.PIPE, text=True).stdout
    return re.search("^host: (.*)$", told, re.M)[1]


def linked(package: str, target: str) -> dict[tuple[str, str], list[str]]:
    """Return the crates linked into `package`, by name and version, with their features."""
    tree = cargo(
        *["tree", "--package", package, "--target", target, "--edges", "normal,no-proc-macro"],
        *["--prefix", "none", "--no-dedupe", "--format", "{p}|{f}"],
    )
    found: dict[tuple[str, str], list[str]] = {}
    for line in tree.splitlines():
        crate, features = line.split("|")
        name, version = crate.split()[:2]
        known = found.setdefault((name, version.removeprefix("v")), [])
        known.extend(each for each in features.split(",") if each and each not in known)
    return found


def bill(package: str, target: str) -> dict[str, Any]:
    """Return the bill of materials of `package` built for `target`."""
    crates = linked(package, target)
    metadata = json.loads(cargo("metadata", "--format-version", "1", "--filter-platform", target))
    known = {each["id"]: (each["name"], each["version"]) for each in metadata["packages"]}
    about = {known[each["id"]]: each for each in metadata["packages"]}
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text())["package"]
    sums = {(each["name"], each["version"]): each.get("checksum") for each in lock}

    def reference(crate: tuple[str, str]) -> str:
        return f"pkg:cargo/{crate[0]}@{crate[1]}"

    def component(crate: tuple[str, str], kind: str = "library") -> dict[str, Any]:
        license = (about[crate]["license"] or "NOASSERTION").replace("/", " OR ")
        made = {
            "type": kind,
            "bom-ref": reference(crate),
            "name": crate[0],
            "version": crate[1],
            "licenses": [{"expression": license}],
            "purl": reference(crate),
        }
        if sums[crate]:
            made["hashes"] = [{"alg": "SHA-256", "content": sums[crate]}]
        if crates[crate]:
            features = ",".join(sorted(crates[crate]))
            made["properties"] = [{"name": "cargo:features", "value": features}]
        return made

    def needs(node: dict[str, Any]) -> list[str]:
        normal = [each for each in node["deps"] if any(kind["kind"] is None for kind in each["dep_kinds"])]
        return sorted(reference(known[each["pkg"]]) for each in normal if known[each["pkg"]] in crates)

    [top] = [crate for crate in crates if crate[0] == package]
    nodes = {known[node["id"]]: node for node in metadata["resolve"]["nodes"]}
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {
            "component": component(top, "application"),
            "properties": [{"name": "cargo:target", "value": target}],
        },
        "components": [component(crate) for crate in sorted(crates) if crate != top],
        "dependencies": [{"ref": reference(crate), "dependsOn": needs(nodes[crate])} for crate in sorted(crates)],
    }


def put(wheel: pathlib.Path, bytes: bytes) -> None:
    """Add a bill to a wheel and its list of files, or replace the existing one."""
    with zipfile.ZipFile(wheel) as old:
        files = [(each, old.read(each)) for each in old.infolist()]
    [record] = [each.filename for each, _ in files if re.fullmatch(r"[^/]+\.dist-info/RECORD", each.filename)]
    path = f"{record.removesuffix('/RECORD')}/sboms/{BILL}"
    digest = base64.urlsafe_b64encode(hashlib.sha256(bytes).digest()).rstrip(b"=").decode()
    row = f"{path},sha256={digest},{len(bytes)}"
    made = wheel.with_suffix(".new")
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as new:
        for each, content in files:
            if each.filename == path:
                continue
            if each.filename == record:
                # The list is the last file, and its own row is the last in it.
                rows = [line for line in content.decode().splitlines() if not line.startswith(f"{path},")]
                own = [line for line in rows if line.startswith(f"{record},")]
                rows = [line for line in rows if line not in own] + [row] + own
                entry = zipfile.ZipInfo(path, each.date_time)
                entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, each.external_attr
                new.writestr(entry, bytes)
                content = ("\n".join(rows) + "\n").encode()
            new.writestr(each, content)
    made.replace(wheel)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("package", choices=["stiction-cli", "stiction-python"], help="the product")
    parser.add_argument("--target", default=None, help="the target of the build, by default this machine's")
    parser.add_argument("--wheel", type=pathlib.Path, help="add the bill to this wheel instead of printing it")
    arguments = parser.parse_args()
    made = json.dumps(bill(arguments.package, arguments.target or host()), indent=1, ensure_ascii=False) + "\n"
    if arguments.wheel is None:
        print(made, end="")
    else:
        put(arguments.wheel, made.encode())


if __name__ == "__main__":
    main()
