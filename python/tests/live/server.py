"""An OPC UA server that plays the recording of a plant, and records every request that it gets.

    python python/tests/live/server.py --plant north --port 48400 --speed 100

It listens on 127.0.0.1 only. Its clock is that of the recording, and runs faster. Orders come as lines on standard input:

    play              begins
    jump SECONDS      moves the clock
    remove TAG        removes a node
    type TAG          makes the tag a text
    skip              leaves out the next notification
    flood N SECONDS   writes N values a second to the tags in turn
    requests          prints the number of requests by service, as JSON
    quit
"""

from __future__ import annotations

import argparse
import asyncio
import glob
import ipaddress
import json
import logging
import sys
import time
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from asyncua import Server, ua
from asyncua.crypto import cert_gen, security_policies
from asyncua.server import uaprocessor
from asyncua.server.history import HistoryStorageInterface
from asyncua.server.internal_subscription import InternalSubscription
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding
from cryptography.x509.oid import ExtendedKeyUsageOID

EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)
URI = "urn:stiction:played"
NAMES = {value: name.removesuffix("_Encoding_DefaultBinary") for name, value in vars(ua.ObjectIds).items() if name.endswith("Request_Encoding_DefaultBinary")}


def at(us: int) -> datetime:
    return EPOCH + timedelta(microseconds=int(us))


def played(plant: Path, loops: int | None) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """The times, in microseconds, and values of each tag."""
    tables = [pq.read_table(path) for path in sorted(glob.glob(str(plant / "data" / "**" / "*.parquet"), recursive=True))]
    table = pa.concat_tables(tables, promote_options="permissive").sort_by([("tag", "ascending"), ("time", "ascending")])
    times = table["time"].cast(pa.timestamp("us", "UTC")).cast(pa.int64()).to_numpy()
    values = table["value"].to_numpy()
    tags = table["tag"].combine_chunks().dictionary_encode()
    codes, names = tags.indices.to_numpy(), tags.dictionary.to_pylist()
    edges = np.searchsorted(codes, np.arange(len(names) + 1))
    found = {name: (times[edges[k] : edges[k + 1]], values[edges[k] : edges[k + 1]]) for k, name in enumerate(names)}
    if loops is not None:
        chosen = sorted({name.partition(".")[0] for name in found}, key=lambda name: name[-4:])[:loops]
        found = {name: own for name, own in found.items() if name.partition(".")[0] in chosen}
    return found


class History(HistoryStorageInterface):
    """The history of the played values."""

    def __init__(self, of: Played) -> None:
        super().__init__()
        self.of = of

    async def init(self) -> None:
        pass

    async def stop(self) -> None:
        pass

    async def read_node_history(self, node_id, start, end, nb_values):
        tag = node_id.Identifier
        times, values = self.of.data[tag]
        whole = lambda moment: int((moment.replace(tzinfo=timezone.utc) - EPOCH) / timedelta(microseconds=1))  # noqa: E731
        first, last = np.searchsorted(times, [whole(start), min(whole(end), self.of.clock, self.of.end) + 1])
        until = min(last, first + (nb_values or last))
        data = [
            ua.DataValue(ua.Variant(float(values[k]), ua.VariantType.Double), SourceTimestamp=at(times[k]), ServerTimestamp=at(times[k]))
            for k in range(first, until)
        ]
        return data, at(times[until]) if until < last else None


class Played:
    """The server, and how far it has played."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options
        self.data = played(options.plant, options.loops)
        self.begin = min(int(times[0]) for times, _ in self.data.values())
        self.end = max(int(times[-1]) for times, _ in self.data.values())
        if options.first is not None:
            self.begin += int(options.first * 1e6)
        if options.last is not None:
            self.end = min(self.end, self.begin + int(options.last * 1e6))
        self.clock = self.begin
        self.shift = 0
        self.next = {tag: int(np.searchsorted(times, self.begin)) for tag, (times, _) in self.data.items()}
        self.requests: dict[str, int] = {}
        self.playing = asyncio.Event()
        self.nodes: dict[str, ua.NodeId] = {}
        self.flooding = 0

    def record(self) -> None:
        """Counts every request that any client sends."""
        process, count = uaprocessor.UaProcessor._process_message, self.requests

        async def counted(own, typeid, requesthdr, seqhdr, body):
            name = NAMES.get(typeid.Identifier, str(typeid.Identifier))
            count[name] = count.get(name, 0) + 1
            return await process(own, typeid, requesthdr, seqhdr, body)

        uaprocessor.UaProcessor._process_message = counted

    def leave_out(self) -> None:
        """Has the next notification lost once."""
        pop = InternalSubscription._pop_publish_result

        def popped(own):
            result = pop(own)
            if result.NotificationMessage.NotificationData and own.pub_request_callback:
                InternalSubscription._pop_publish_result = pop
                return pop(own)
            return result

        InternalSubscription._pop_publish_result = popped

    async def run(self) -> None:
        self.record()
        server = Server()
        # A tag may change its type.
        server.iserver.aspace._is_expected_variant_type = lambda *_: True
        server.iserver.disabled_clock = True
        await server.init()
        server.set_endpoint(f"opc.tcp://127.0.0.1:{self.options.port}")
        await server.set_application_uri(URI)
        await self.secure(server)
        if not self.options.no_history:
            server.iserver.history_manager.set_storage(History(self))
        space = await server.register_namespace(URI)
        folder = await server.nodes.objects.add_folder(ua.NodeId("Plant", space), "Plant")
        for tag in self.data:
            node = ua.NodeId(tag, space)
            self.nodes[tag] = node
            await folder.add_variable(node, tag, 0.0, ua.VariantType.Double, ua.NodeId(ua.ObjectIds.BaseDataType))
            await self.put(server, tag, ua.DataValue(StatusCode=ua.StatusCode(ua.StatusCodes.BadWaitingForInitialData), SourceTimestamp=at(self.begin)))
        await self.tell(server)
        async with server:
            print(json.dumps({"listening": self.options.port, "tags": len(self.data), "begin": self.begin, "end": self.end}), flush=True)
            player = asyncio.create_task(self.play(server))
            await self.orders(server)
            player.cancel()

    async def secure(self, server: Server) -> None:
        policies = [] if self.options.encrypted else [ua.SecurityPolicyType.NoSecurity]
        if self.options.encrypted:
            folder = self.options.encrypted
            folder.mkdir(parents=True, exist_ok=True)
            if not (folder / "server.der").exists():
                make_certificate(folder, self.options.certificate_days)
            await server.load_certificate(str(folder / "server.der"))
            await server.load_private_key(str(folder / "server.pem"))
            policies = [ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt, ua.SecurityPolicyType.Aes256Sha256RsaPss_SignAndEncrypt]
        server.set_security_policy(policies)
        if self.options.user:
            from asyncua.server.user_managers import User, UserRole

            name, password = self.options.user.split(":")

            class Manager:
                def get_user(self, iserver, username=None, password=None, certificate=None, _known=(name, password)):
                    return User(role=UserRole.User) if (username, password) == _known else None

            server.iserver.user_manager = Manager()
            server.set_identity_tokens([ua.UserNameIdentityToken])

    async def put(self, server: Server, tag: str, value: ua.DataValue) -> None:
        await server.write_attribute_value(self.nodes[tag], value)

    async def tell(self, server: Server) -> None:
        now = at(self.clock + self.shift)
        await server.iserver.current_time_node.write_value(now)

    async def play(self, server: Server) -> None:
        await self.playing.wait()
        begun, from_ = time.monotonic(), self.clock
        while self.clock < self.end:
            await asyncio.sleep(0.02)
            now = min(self.end, from_ + int((time.monotonic() - begun) * 1e6 * self.options.speed))
            for tag, (times, values) in self.data.items():
                k = self.next[tag]
                while k < len(times) and times[k] <= now:
                    if tag in self.nodes:
                        value = ua.DataValue(ua.Variant(float(values[k]), ua.VariantType.Double), SourceTimestamp=at(times[k] + self.shift), ServerTimestamp=at(times[k] + self.shift))
                        await self.put(server, tag, value)
                    k += 1
                self.next[tag] = k
            self.clock = now
            await self.tell(server)
        print(json.dumps({"played": self.end}), flush=True)
        # The clock goes on, so that the last hour ends, and stops before the next one does, which would be judged, too.
        begun, hour = time.monotonic(), 3_600_000_000
        last = -(-self.end // hour) * hour + hour // 2
        while True:
            await asyncio.sleep(0.1)
            self.clock = min(last, self.end + int((time.monotonic() - begun) * 1e6 * self.options.speed))
            await self.tell(server)

    async def flood(self, server: Server, rate: int, seconds: float) -> None:
        tags, begun, sent = list(self.data), time.monotonic(), 0
        while (passed := time.monotonic() - begun) < seconds:
            while sent < passed * rate:
                stamp = at(self.clock + sent)
                await self.put(server, tags[sent % len(tags)], ua.DataValue(ua.Variant(float(sent), ua.VariantType.Double), SourceTimestamp=stamp, ServerTimestamp=stamp))
                sent += 1
            await asyncio.sleep(0.005)
        self.flooding = sent
        print(json.dumps({"flooded": sent, "seconds": round(passed, 1)}), flush=True)

    async def orders(self, server: Server) -> None:
        reader = asyncio.StreamReader()
        await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
        while line := (await reader.readline()).decode().split():
            match line:
                case ["play"]:
                    self.playing.set()
                case ["jump", seconds]:
                    self.shift += int(float(seconds) * 1e6)
                    await self.tell(server)
                case ["remove", tag]:
                    await server.delete_nodes([server.get_node(self.nodes.pop(tag))])
                case ["type", tag]:
                    stamp = at(self.clock + self.shift)
                    await self.put(server, tag, ua.DataValue(ua.Variant("out of order", ua.VariantType.String), SourceTimestamp=stamp, ServerTimestamp=stamp))
                case ["skip"]:
                    self.leave_out()
                case ["flood", rate, seconds]:
                    await self.flood(server, int(rate), float(seconds))
                case ["requests"]:
                    print(json.dumps({"requests": self.requests}), flush=True)
                case ["quit"]:
                    return


def make_certificate(folder: Path, days: int) -> None:
    """A certificate of the server; one of less than a day has expired."""
    key = cert_gen.generate_private_key()
    names = [x509.UniformResourceIdentifier(URI), x509.IPAddress(ipaddress.ip_address("127.0.0.1"))]
    made = cert_gen.generate_self_signed_app_certificate(key, "played", {}, names, [ExtendedKeyUsageOID.SERVER_AUTH], days)
    (folder / "server.der").write_bytes(made.public_bytes(Encoding.DER))
    (folder / "server.pem").write_bytes(cert_gen.dump_private_key_as_pem(key))


def main() -> None:
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--plant", type=Path, required=True)
    arguments.add_argument("--port", type=int, required=True)
    arguments.add_argument("--speed", type=float, default=1.0)
    arguments.add_argument("--loops", type=int, help="play only so many loops")
    arguments.add_argument("--first", type=float, help="begin this many seconds after the beginning")
    arguments.add_argument("--last", type=float, help="play only this many seconds")
    arguments.add_argument("--no-history", action="store_true")
    arguments.add_argument("--encrypted", type=Path, metavar="DIR", help="encrypt, with a certificate that is made there")
    arguments.add_argument("--certificate-days", type=int, default=30)
    arguments.add_argument("--user", metavar="NAME:PASSWORD")
    logging.basicConfig(level=logging.CRITICAL)
    asyncio.run(Played(arguments.parse_args()).run())


if __name__ == "__main__":
    main()
