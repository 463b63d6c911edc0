"""Live data of a plant: OPC UA servers, SQL databases and PI, all of them only read.

``python -m stiction.live watch opc.tcp://server:4840 -C north`` collects and judges a plant day and night, and ``stiction watch`` is
the same. The extra ``stiction[live]`` has what it needs. ``docs/live.md`` describes it.
"""

from __future__ import annotations

from stiction.live.errors import Refused

__all__ = ["Refused"]
