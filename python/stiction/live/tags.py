"""The tags of a plant on a server, from ``live.toml`` beside ``plant.toml``, or from the names of the server's variables."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from stiction import _core
from stiction.live import opcua
from stiction.live.errors import Refused

__all__: list[str] = []

NAME = "live.toml"
"""The name of the file."""
MODES = {"manual": 0.0, "auto": 1.0, "cascade": 2.0}
_LINE = re.compile(r'\s*("(?:[^"\\]|\\.)*")\s*=\s*("(?:[^"\\]|\\.)*")\s*(?:#.*)?')
_MODE = re.compile(r'\s*"?([^"=]+?)"?\s*=\s*"(auto|manual|cascade)"\s*(?:#.*)?')


def mode_words(text: str) -> dict[str, float]:
    """The numbers for the words of modes under ``[modes]`` of a plant's file. Codes stay unchanged."""
    found, within = {}, False
    for line in text.split("\n"):
        if line.strip().startswith("["):
            within = line.strip().replace(" ", "") == "[modes]"
        elif within and (match := _MODE.fullmatch(line)):
            word, mode = match.groups()
            if not re.fullmatch(r"[-+0-9.]+", word):
                found[word.lower()] = MODES[mode]
    return found


def read(path: Path) -> dict[str, str]:
    """The nodes of the tags in a file."""
    found: dict[str, str] = {}
    within = False
    for number, line in enumerate(path.read_text(encoding="utf-8").split("\n"), 1):
        bare = line.strip()
        if not bare or bare.startswith("#"):
            continue
        if bare.startswith("["):
            within = bare.replace(" ", "") == "[tags]"
            if not within:
                raise Refused(f"{path}, line {number}: {bare} is not known; list tags below [tags]")
            continue
        match = _LINE.fullmatch(line)
        if not within or match is None:
            raise Refused(f'{path}, line {number}: write "TAG" = "NODE", such as "FIC101.PV" = "nsu=urn:plant;s=FIC101.PV"')
        tag, node = (json.loads(each) for each in match.groups())
        if tag in found:
            raise Refused(f"{path}, line {number}: {tag} is listed twice; remove one of the lines")
        found[tag] = node
    return found


def text_of(tags: Mapping[str, str], url: str) -> str:
    """The text of a file."""
    lines = [f"# Tags of {url}, and their nodes. Remove lines of tags that are not needed.", "[tags]"]
    lines += [f"{json.dumps(tag, ensure_ascii=False)} = {json.dumps(node, ensure_ascii=False)}" for tag, node in tags.items()]
    return "\n".join(lines) + "\n"


async def of_server(file: _core.Plant, server: opcua.Server, say: Callable[[str], None]) -> dict[str, str]:
    """The variables of a server whose node identifiers or paths are tags of loops."""
    found = await server.browse()
    chosen: dict[str, str] = {}
    most = 0
    for by_path in (False, True):
        names = opcua.names_of(found, by_path)
        listed = sorted(names)
        loops = file.loops(listed, [])
        if len(loops) > most:
            most = len(loops)
            chosen = {listed[k]: names[listed[k]] for _, own, _ in loops for k in own}
    say(f"the server has {len(found)} variables; {len(chosen)} of them belong to {most} loops")
    return dict(sorted(chosen.items()))


async def of_plant(plant: Path, file: _core.Plant, server: opcua.Server, say: Callable[[str], None]) -> dict[str, str]:
    """The tags of a plant, from the file `NAME`. Without the file, the tags come from the server, and the file is written.
    """
    path = plant / NAME
    if path.exists():
        known = read(path)
        if not known:
            raise Refused(f"{path}: lists no tags; remove the file, and a new file is made")
        return known
    tags: dict[str, Any] = await of_server(file, server, say)
    if not tags:
        raise Refused(
            f"no variable of {server.url} has the name of a loop's tag; list the tags in {path}, as in "
            '"FIC101.PV" = "nsu=urn:plant;s=FIC101.PV" below [tags], and name them in plant.toml'
        )
    path.write_text(text_of(tags, server.url), encoding="utf-8")
    say(f"{path} lists the tags; correct a wrong file and start again")
    return tags
