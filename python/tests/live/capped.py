"""An OPC UA server with the history that asyncua brings, which cuts its answers at a number of values.

    python python/tests/live/capped.py --port 48620 --values 12000 --cap 10000

Of three tags it has values 2 s apart up to noon of 2 March 2026. Its clock begins there and runs fast. With a cap of 10,000, which is what a client
asks for, an answer of 10,000 values comes without a continuation point.
"""

import argparse
import asyncio
import logging
import sys
import time
from datetime import datetime, timedelta, timezone

from asyncua import Server, ua
from asyncua.server.history import HistoryDict

NOON = datetime(2026, 3, 2, 12, 0, 0, tzinfo=timezone.utc)
TAGS = ("FIC101.OP", "FIC101.PV", "FIC101.SP")
STEP_S = 2


def value_of(tag: str, number: int) -> float:
    return 40.0 + TAGS.index(tag) + (number % 977) / 100.0


class Habits(HistoryDict):
    """The history of asyncua, which may also answer the newest values first."""

    newest = False

    async def read_node_history(self, node_id, start, end, nb_values):
        if not self.newest:
            return await super().read_node_history(node_id, start, end, nb_values)
        found = [value for value in self._datachanges.get(node_id, []) if start <= value.SourceTimestamp <= end]
        return found[::-1][: self.max_history_data_response_size], None


async def main() -> None:
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--port", type=int, required=True)
    arguments.add_argument("--values", type=int, default=12_000)
    arguments.add_argument("--cap", type=int, default=10_000)
    arguments.add_argument("--speed", type=float, default=60.0)
    arguments.add_argument("--newest", action="store_true")
    options = arguments.parse_args()
    logging.basicConfig(level=logging.CRITICAL)
    server = Server()
    await server.init()
    history = Habits(max_history_data_response_size=options.cap)
    history.newest = options.newest
    server.iserver.history_manager.set_storage(history)
    server.iserver.disabled_clock = True
    server.set_endpoint(f"opc.tcp://127.0.0.1:{options.port}")
    server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    space = await server.register_namespace("urn:stiction:capped")
    nodes = {tag: await server.nodes.objects.add_variable(ua.NodeId(tag, space), tag, 0.0, ua.VariantType.Double) for tag in TAGS}

    def of(tag: str, number: int) -> ua.DataValue:
        at = NOON + timedelta(seconds=STEP_S * (number - options.values))
        return ua.DataValue(ua.Variant(value_of(tag, number), ua.VariantType.Double), SourceTimestamp=at, ServerTimestamp=at)

    for tag, node in nodes.items():
        await history.new_historized_node(node.nodeid, None, 0)
        for number in range(options.values):
            await history.save_node_value(node.nodeid, of(tag, number))
    number = options.values - 1
    for tag, node in nodes.items():
        await server.write_attribute_value(node.nodeid, of(tag, number))
    await server.iserver.current_time_node.write_value(NOON)
    async with server:
        print('{"listening": true}', flush=True)
        loop = asyncio.get_running_loop()
        play = loop.run_in_executor(None, sys.stdin.readline)
        await play
        begun = time.monotonic()
        while True:
            now = NOON + timedelta(seconds=options.speed * (time.monotonic() - begun))
            while number + 1 <= options.values + int((now - NOON).total_seconds() / STEP_S):
                number += 1
                for tag, node in nodes.items():
                    await history.save_node_value(node.nodeid, of(tag, number))
                    await server.write_attribute_value(node.nodeid, of(tag, number))
            await server.iserver.current_time_node.write_value(now)
            await asyncio.sleep(0.02)


if __name__ == "__main__":
    asyncio.run(main())
