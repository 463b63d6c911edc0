"""A client of OPC UA servers that can only read.

Every request passes `ReadOnlyProtocol`, which sends only the services of `SERVICES`. A request to write a value, call a
method or change nodes raises `Refused` before the request is encoded.

The client is `asyncua`_, which encrypts with OpenSSL through ``cryptography``. The Rust client would use the crate ``rsa``, whose
private key can leak through response times (RUSTSEC-2023-0071, without a fix).

.. _asyncua: https://github.com/FreeOpcUa/opcua-asyncio
"""

from __future__ import annotations

import asyncio
import hashlib
import ipaddress
import logging
import os
import socket
import time
from collections.abc import AsyncIterator, Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

try:
    from asyncua import Client, ua
    from asyncua.client.ua_client import UaClient, UASocketProtocol
    from asyncua.common.shortcuts import Shortcuts
    from asyncua.crypto import cert_gen, security_policies
    from cryptography import x509
    from cryptography.hazmat.primitives.serialization import Encoding
    from cryptography.x509.oid import ExtendedKeyUsageOID
except ImportError as error:
    raise ImportError(f'OPC UA needs asyncua ({error}): pip install "stiction[live]"') from None

from stiction.live.errors import Refused, refuse_password
from stiction.live.history import IDLE, MOST_S, Answer, Reading, Unread

__all__: list[str] = []

logging.getLogger("asyncua").setLevel(logging.CRITICAL + 1)

SERVICES: frozenset[type] = frozenset(
    {
        ua.ActivateSessionRequest,
        ua.BrowseNextRequest,
        ua.BrowseRequest,
        ua.CloseSecureChannelRequest,
        ua.CloseSessionRequest,
        ua.CreateMonitoredItemsRequest,
        ua.CreateSessionRequest,
        ua.CreateSubscriptionRequest,
        ua.DeleteMonitoredItemsRequest,
        ua.DeleteSubscriptionsRequest,
        ua.FindServersRequest,
        ua.GetEndpointsRequest,
        ua.HistoryReadRequest,
        ua.ModifyMonitoredItemsRequest,
        ua.ModifySubscriptionRequest,
        ua.OpenSecureChannelRequest,
        ua.PublishRequest,
        ua.ReadRequest,
        ua.RepublishRequest,
        ua.SetPublishingModeRequest,
        ua.TranslateBrowsePathsToNodeIdsRequest,
    }
)
"""The permitted requests. No service writes a value, changes a node or calls a method."""

POLICIES: dict[str, Any] = {
    "Aes256Sha256RsaPss": security_policies.SecurityPolicyAes256Sha256RsaPss,
    "Aes128Sha256RsaOaep": security_policies.SecurityPolicyAes128Sha256RsaOaep,
    "Basic256Sha256": security_policies.SecurityPolicyBasic256Sha256,
}
"""The accepted security policies, the best first."""

APPLICATION = "urn:stiction:watch"
EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)
MICROSECOND = timedelta(microseconds=1)
AT_ONCE = 500
"""Maximum number of nodes of one request."""
MOST_NODES = 500_000
"""Maximum number of nodes that are browsed."""
OVERFLOW = 0x480
"""The bits of a status code that report an overflow of the server's queue before this value."""
NO_FILTER = (
    ua.StatusCodes.BadMonitoredItemFilterUnsupported,
    ua.StatusCodes.BadMonitoredItemFilterInvalid,
    ua.StatusCodes.BadFilterNotAllowed,
)


NO_HISTORY = (
    ua.StatusCodes.BadHistoryOperationUnsupported,
    ua.StatusCodes.BadHistoryOperationInvalid,
    ua.StatusCodes.BadNotImplemented,
    ua.StatusCodes.BadNotSupported,
    ua.StatusCodes.BadServiceUnsupported,
    ua.StatusCodes.BadUserAccessDenied,
)


NO_BOUND = ua.StatusCodes.BadBoundNotFound
"""The status of a history bound that has no value."""
NO_DATA = (ua.StatusCodes.BadNoData, ua.StatusCodes.GoodNoData)
TOO_LARGE = (
    ua.StatusCodes.BadEncodingLimitsExceeded,
    ua.StatusCodes.BadRequestTooLarge,
    ua.StatusCodes.BadResponseTooLarge,
    ua.StatusCodes.BadTcpMessageTooLarge,
    ua.StatusCodes.BadTooManyOperations,
)


class ReadOnlyProtocol(UASocketProtocol):
    """Sends the requests of `SERVICES` and refuses all other requests."""

    def _send_request(
        self, request: Any, timeout: float = 1, message_type: ua.MessageType = ua.MessageType.SecureMessage
    ) -> asyncio.Future[Any]:
        if type(request) not in SERVICES:
            raise Refused(f"{type(request).__name__} was not sent, because stiction only reads from a server")
        future: asyncio.Future[Any] = super()._send_request(request, timeout, message_type)
        return future


class _Transport(UaClient):
    def _make_protocol(self) -> UASocketProtocol:
        self.protocol = ReadOnlyProtocol(self._timeout, security_policy=self.security_policy)
        self.protocol.pre_request_hook = self._pre_request_hook
        self.protocol.on_connection_lost = self._on_transport_lost
        self.protocol.is_session_closing = self._is_session_closing
        return self.protocol


class ReadOnlyClient(Client):
    """A client whose connection is a `ReadOnlyProtocol`."""

    def __init__(self, url: str, timeout: float) -> None:
        super().__init__(url, timeout=timeout, watchdog_intervall=max(timeout, 5.0))
        self.uaclient = _Transport(timeout)
        self.uaclient.pre_request_hook = self._wait_until_ready
        self.nodes = Shortcuts(self.uaclient.session)
        self.name = self.description = "stiction watch"
        self.application_uri = APPLICATION
        self.product_uri = APPLICATION
        # A session whose client was killed ends after this time, ms.
        self.session_timeout = 120_000
        self.check_peer: Callable[[], None] = lambda: None

    def _add_user_auth(self, params: Any, username: str | None, password: str | None) -> None:
        policy = self.server_policy(ua.UserTokenType.UserName)
        encrypted = self.security_policy.Mode == ua.MessageSecurityMode.SignAndEncrypt
        plain = policy.SecurityPolicyUri in (None, "", security_policies.SecurityPolicyNone.URI)
        if plain and not encrypted:
            raise Refused(
                "the server would receive the user and the password unencrypted, so they were not sent; use a security policy, or a "
                "server that encrypts passwords"
            )
        if not encrypted:
            # The server's certificate encrypts the password, so it must be a trusted one.
            self.check_peer()
        super()._add_user_auth(params, username, password)


@dataclass
class Security:
    """The security settings of a connection."""

    policy: str | None = None
    """The name of a policy, or ``none``; by default the best policy of the server."""
    folder: Path = Path("certificates")
    """The folder with the client's certificate ``client.der`` and key ``client.pem``, and with ``trusted`` and ``rejected``."""
    trust_first: bool = False
    """Whether the first certificate of a server is trusted without a check."""
    user_certificate: Path | None = None
    user_key: Path | None = None
    any_name: bool = False
    """Whether a certificate may be for a different application or host."""


def make_certificate(folder: Path, days: int = 1825) -> str:
    """Make the client's certificate and key in a folder, and return the fingerprint of the certificate."""
    folder.mkdir(parents=True, exist_ok=True)
    key_path, path = folder / "client.pem", folder / "client.der"
    if key_path.exists() or path.exists():
        raise Refused(f"{path if path.exists() else key_path} exists already; move both files away to make new ones")
    key = cert_gen.generate_private_key()
    host = socket.gethostname()
    names: list[x509.GeneralName] = [x509.UniformResourceIdentifier(APPLICATION), x509.DNSName(host)]
    made = cert_gen.generate_self_signed_app_certificate(
        key, f"stiction@{host}", {"organizationName": "stiction"}, names, [ExtendedKeyUsageOID.CLIENT_AUTH], days
    )
    handle = os.open(key_path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(handle, "wb") as file:
        file.write(cert_gen.dump_private_key_as_pem(key))
    path.write_bytes(made.public_bytes(Encoding.DER))
    for name in ("trusted", "rejected"):
        (folder / name).mkdir(exist_ok=True)
    return fingerprint(path.read_bytes())


def fingerprint(certificate: bytes) -> str:
    """The SHA-256 of a certificate (DER)."""
    return hashlib.sha256(certificate).hexdigest()


def _loaded(path: Path) -> x509.Certificate:
    data = path.read_bytes()
    return x509.load_pem_x509_certificate(data) if data.startswith(b"-----") else x509.load_der_x509_certificate(data)


def check_certificate(data: bytes, uri: str | None, host: str, security: Security) -> str | None:
    """Check the certificate of a server on a host against the trusted certificates, and return a note, if any. `uri` is the URI of
    the server's application, if known.

    Raises
    ------
    Refused
        If the certificate is not valid or not trusted. The message states the remedy.
    """
    certificate = x509.load_der_x509_certificate(data)
    mark = fingerprint(data)
    now = datetime.now(timezone.utc)
    name = certificate.subject.rfc4514_string()
    if not certificate.not_valid_before_utc <= now <= certificate.not_valid_after_utc:
        raise Refused(
            f"the certificate of the server ({name}) is valid from {certificate.not_valid_before_utc:%Y-%m-%d} to "
            f"{certificate.not_valid_after_utc:%Y-%m-%d}, and today is {now:%Y-%m-%d}; renew it on the server, or correct the clock "
            "of this computer"
        )
    if not security.any_name:
        uris, hosts = _names(certificate)
        remedy = "make a new certificate on the server, or accept any name with --any-name"
        if uri is not None and uri not in uris:
            raise Refused(f"the certificate of the server ({name}) is for {', '.join(uris) or 'no application'}, but the server is {uri}; {remedy}")
        # On this computer, its own name is as good.
        here = {socket.gethostname().lower()} if host == "localhost" or host.startswith("127.") or host == "::1" else set()
        if not hosts & (here | {_plain(host)}):
            raise Refused(
                f"the certificate of the server ({name}) is for {', '.join(sorted(hosts)) or 'no host'}, but the address names {host}; "
                f"name the host as the certificate does, {remedy}"
            )
    trusted, rejected = security.folder / "trusted", security.folder / "rejected"
    known = [path for path in sorted(trusted.glob("*")) if path.suffix in {".der", ".pem", ".crt", ".cer"}]
    is_trusted, aside = False, []
    for path in known:
        try:
            each = _loaded(path)
        except (ValueError, OSError):
            aside.append(f"{path} is not a certificate; remove the file")
            continue
        if each.public_bytes(Encoding.DER) == data or (why := _no_issuer(each, certificate, now)) is None:
            is_trusted = True
        elif why:
            aside.append(f"{path} {why}")
    if is_trusted:
        return ". ".join(aside[:3]) or None
    if security.trust_first and not known:
        trusted.mkdir(parents=True, exist_ok=True)
        (trusted / f"{mark[:16]}.der").write_bytes(data)
        return f"the certificate of the server ({name}, SHA-256 {mark}) is trusted from now on, because --trust-first was given"
    rejected.mkdir(parents=True, exist_ok=True)
    path = rejected / f"{mark[:16]}.der"
    path.write_bytes(data)
    raise Refused(
        f"the certificate of the server ({name}, SHA-256 {mark}) is not trusted; compare the SHA-256 with that on the server, and "
        f"move {path} to {trusted}" + "".join(f". Also, {each}" for each in aside[:3])
    )


def _plain(host: str) -> str:
    """A host in a uniform spelling."""
    try:
        return str(ipaddress.ip_address(host))
    except ValueError:
        return host.rstrip(".").lower()


def _names(certificate: x509.Certificate) -> tuple[list[str], set[str]]:
    """The URIs of applications and the hosts that a certificate is for."""
    try:
        own = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except x509.ExtensionNotFound:
        return [], set()
    hosts = [*own.get_values_for_type(x509.DNSName), *map(str, own.get_values_for_type(x509.IPAddress))]
    return own.get_values_for_type(x509.UniformResourceIdentifier), set(map(_plain, hosts))


def _no_issuer(issuer: x509.Certificate, certificate: x509.Certificate, now: datetime) -> str | None:
    """Why a trusted certificate is no valid issuer of a server's certificate. The reason is empty if the certificate did not sign
    the server's certificate, and None for a valid issuer.
    """
    try:
        certificate.verify_directly_issued_by(issuer)
    except Exception:
        return ""
    is_authority = False
    try:
        is_authority = issuer.extensions.get_extension_for_class(x509.BasicConstraints).value.ca
        is_authority = is_authority and issuer.extensions.get_extension_for_class(x509.KeyUsage).value.key_cert_sign
    except x509.ExtensionNotFound as missing:
        # Without the second one, its key has any use.
        is_authority = is_authority and missing.oid == x509.KeyUsage.oid
    if not is_authority:
        return "signed it, but is not the certificate of an authority (CA)"
    if not issuer.not_valid_before_utc <= now <= issuer.not_valid_after_utc:
        return f"signed it, but is valid from {issuer.not_valid_before_utc:%Y-%m-%d} to {issuer.not_valid_after_utc:%Y-%m-%d} only"
    return None


@dataclass(frozen=True)
class Found:
    """A variable of a server."""

    node: str
    """Node of the variable, such as ``nsu=urn:plant;s=FIC101.PV``."""
    identifier: str
    """Text of the node's identifier; empty for a number."""
    path: str
    """Browse path of the variable, such as ``Unit 1/FIC101.PV``."""


@dataclass
class Monitored:
    """A tag on the server."""

    index: int
    node: Any
    status: int = 0
    """The server's status of the monitoring of this tag."""


def microseconds(at: datetime) -> int:
    """A time of the server, microseconds since 1970-01-01 UTC."""
    if at.tzinfo is None:
        at = at.replace(tzinfo=timezone.utc)
    return (at - EPOCH) // MICROSECOND


class Server:
    """A connection to a server."""

    def __init__(self, url: str, security: Security, *, timeout: float = 10.0, say: Callable[[str], None]) -> None:
        refuse_password(url, "STICTION_OPCUA_PASSWORD")
        try:
            parts = urlsplit(url)
            port = parts.port
        except ValueError:
            parts, port = urlsplit(""), None
        if parts.scheme != "opc.tcp" or not parts.hostname:
            raise Refused(f"{url} is not the address of an OPC UA server, such as opc.tcp://server:4840")
        self.host, self.url = parts.hostname, url if port else url.replace(parts.netloc, f"{parts.netloc}:4840", 1)
        self.security, self.timeout, self.say = security, timeout, say
        self.client: ReadOnlyClient | None = None
        self.namespaces: list[str] = []
        self._publishing: asyncio.Task[None] | None = None
        # Nodes of a request for history, values of a node in its answer, and whether values at its edges are asked for.
        self._together, self._count, self._bounds = 20, 10_000, True

    async def connect(self) -> None:
        """Connect, open a session, and read the namespaces."""
        client = ReadOnlyClient(self.url, self.timeout)
        client.check_peer = lambda: self._check_peer(client)
        user = os.environ.get("STICTION_OPCUA_USER") or client._username
        password = os.environ.get("STICTION_OPCUA_PASSWORD")
        if user:
            client.set_user(user)
        if password:
            client.set_password(password)
        await self._secure(client)
        await client.connect()
        self.client = client
        [namespaces] = await self._read([ua.NodeId(ua.ObjectIds.Server_NamespaceArray)])
        self.namespaces = list(namespaces.Value.Value or [])

    async def _secure(self, client: ReadOnlyClient) -> None:
        own = self.security
        asked = own.policy
        if asked is not None and asked.lower() == "none":
            self.say("the connection is not encrypted, because --security none was given")
            await self._user_certificate(client)
            return
        if asked is not None and asked not in POLICIES:
            raise Refused(f'"{asked}" is not a security policy; choose {", ".join(POLICIES)} or none')
        endpoints = await client.connect_and_get_server_endpoints()
        offered = [
            (name, endpoint)
            for name, policy in POLICIES.items()
            for endpoint in endpoints
            if endpoint.SecurityPolicyUri == policy.URI
            and endpoint.SecurityMode == ua.MessageSecurityMode.SignAndEncrypt
            and asked in (None, name)
        ]
        if not offered:
            uris = {str(endpoint.SecurityPolicyUri).rpartition("#")[2] for endpoint in endpoints}
            raise Refused(
                f"the server offers {', '.join(sorted(uris)) or 'no security policy'}, none of which is secure enough; enable "
                "Basic256Sha256 or newer with SignAndEncrypt on the server, or accept an open connection with --security none"
            )
        name, endpoint = offered[0]
        certificate, key = own.folder / "client.der", own.folder / "client.pem"
        if not (certificate.exists() and key.exists()):
            raise Refused(
                f"{certificate} or {key} is missing; make them with: stiction watch --make-certificate --certificates {own.folder}, and "
                "trust client.der on the server"
            )
        self._say_any_name()
        data = _first_certificate(endpoint.ServerCertificate or b"")
        note = check_certificate(data, endpoint.Server.ApplicationUri, self.host, own)
        if note:
            self.say(note)
        await client.set_security(
            POLICIES[name],
            certificate,
            key,
            os.environ.get("STICTION_OPCUA_KEY_PASSWORD"),
            data,
            ua.MessageSecurityMode.SignAndEncrypt,
        )
        self.say(f"the connection is encrypted by {name}")
        await self._user_certificate(client)

    def _check_peer(self, client: ReadOnlyClient) -> None:
        """Refuses to send a name and a password to a server whose certificate is not trusted."""
        self._say_any_name()
        data = client.security_policy.peer_certificate or b""
        try:
            note = check_certificate(_first_certificate(data), None, self.host, self.security)
        except Refused as error:
            raise Refused(f"the user and the password were not sent, because {error}") from None
        if note:
            self.say(note)

    def _say_any_name(self) -> None:
        if self.security.any_name:
            self.say("the names in the server's certificate were not compared, because --any-name was given")

    async def _user_certificate(self, client: ReadOnlyClient) -> None:
        own = self.security
        if own.user_certificate is not None:
            if own.user_key is None:
                raise Refused("a user certificate needs its key; give --user-key")
            await client.load_client_certificate(str(own.user_certificate))
            await client.load_private_key(str(own.user_key), os.environ.get("STICTION_OPCUA_USER_KEY_PASSWORD"))

    async def close(self) -> None:
        """End the session and the connection."""
        client, self.client = self.client, None
        if self._publishing is not None:
            self._publishing.cancel()
            self._publishing = None
        if client is not None:
            try:
                await asyncio.wait_for(client.disconnect(), self.timeout)
            except Exception:
                client.disconnect_socket()

    @property
    def session(self) -> Any:
        if self.client is None:
            raise ConnectionError("not connected")
        return self.client.uaclient.session

    async def _read(self, nodes: Sequence[Any], attribute: Any = ua.AttributeIds.Value) -> list[Any]:
        values: list[Any] = []
        for first in range(0, len(nodes), AT_ONCE):
            parameters = ua.ReadParameters()
            parameters.TimestampsToReturn = ua.TimestampsToReturn.Both
            parameters.NodesToRead = [
                ua.ReadValueId(NodeId=node, AttributeId=attribute) for node in nodes[first : first + AT_ONCE]
            ]
            values += await self.session.read(parameters)
        return values

    async def clock(self) -> int:
        """The server's time."""
        [value] = await self._read([ua.NodeId(ua.ObjectIds.Server_ServerStatus_CurrentTime)])
        at = value.Value.Value if value.Value is not None else None
        if not isinstance(at, datetime):
            raise ConnectionError("the server does not state its time")
        return microseconds(at)

    def node_of(self, text: str) -> Any:
        """The node of a text such as ``nsu=urn:plant;s=FIC101.PV`` or ``ns=2;i=17``; None for an unknown namespace."""
        if text.startswith("nsu="):
            uri, _, rest = text[4:].partition(";")
            if uri not in self.namespaces:
                return None
            text = f"ns={self.namespaces.index(uri)};{rest}"
        try:
            return ua.NodeId.from_string(text)
        except Exception as error:
            raise Refused(f'"{text}" is not the id of a node, such as nsu=urn:plant;s=FIC101.PV or ns=2;i=17') from error

    def text_of(self, node: Any) -> str:
        """The text of a node with the name of the namespace, because the numbers of namespaces may change."""
        rest = node.to_string().partition(";")[2] if node.NamespaceIndex else node.to_string()
        if node.NamespaceIndex and node.NamespaceIndex < len(self.namespaces):
            return f"nsu={self.namespaces[node.NamespaceIndex]};{rest}"
        return str(node.to_string())

    async def browse(self) -> list[Found]:
        """All variables below the Objects folder, except the server's own variables."""
        found: list[Found] = []
        open_: list[tuple[Any, str, bool]] = [(ua.NodeId(ua.ObjectIds.ObjectsFolder), "", False)]
        seen = {open_[0][0]}
        while open_:
            batch, open_ = open_[:100], open_[100:]
            for (_, path, _), references in zip(batch, await self._references([node for node, _, _ in batch])):
                for each in references:
                    node = each.NodeId
                    node = ua.NodeId(node.Identifier, node.NamespaceIndex, node.NodeIdType)
                    if node in seen or node.NamespaceIndex == 0:
                        continue
                    seen.add(node)
                    if len(seen) > MOST_NODES:
                        self.say(f"the server has more than {MOST_NODES} nodes; the others were not browsed")
                        return found
                    name = each.BrowseName.Name or ""
                    is_variable = each.NodeClass == ua.NodeClass.Variable
                    own = name if not path else f"{path}{'.' if is_variable else '/'}{name}"
                    if is_variable:
                        identifier = node.Identifier if isinstance(node.Identifier, str) else ""
                        found.append(Found(self.text_of(node), identifier, own))
                    # The properties of a variable are about it.
                    if not is_variable or not _is_property(each):
                        open_.append((node, own, is_variable))
        return found

    async def _references(self, nodes: Sequence[Any]) -> list[list[Any]]:
        parameters = ua.BrowseParameters()
        parameters.NodesToBrowse = [
            ua.BrowseDescription(
                NodeId=node,
                BrowseDirection=ua.BrowseDirection.Forward,
                ReferenceTypeId=ua.NodeId(ua.ObjectIds.HierarchicalReferences),
                IncludeSubtypes=True,
                NodeClassMask=ua.NodeClass.Object | ua.NodeClass.Variable,
                ResultMask=ua.BrowseResultMask.All,
            )
            for node in nodes
        ]
        results = await self.session.browse(parameters)
        all_: list[list[Any]] = []
        for result in results:
            own = list(result.References or [])
            known, idle = {each.NodeId for each in own}, 0
            while result.ContinuationPoint and idle < IDLE and len(own) <= MOST_NODES:
                more = ua.BrowseNextParameters()
                more.ContinuationPoints = [result.ContinuationPoint]
                [result] = await self.session.browse_next(more)
                new = [each for each in result.References or [] if each.NodeId not in known]
                known.update(each.NodeId for each in new)
                idle = 0 if new else idle + 1
                own += new
            if result.ContinuationPoint:
                self.say("the server's list of the nodes of a folder does not end; the rest was not browsed")
            all_.append(own)
        return all_

    async def subscribe(
        self,
        nodes: Mapping[int, Any],
        on_values: Callable[[Sequence[tuple[int, Any]]], None],
        on_alive: Callable[[], None],
        *,
        publish_s: float,
        sample_s: float,
        queue: int,
    ) -> dict[int, int]:
        """Subscribe to nodes by index, and return the status of each node that the server does not monitor."""
        parameters = ua.CreateSubscriptionParameters()
        parameters.RequestedPublishingInterval = 1000.0 * publish_s
        # A sign of life every few seconds, and an end of the subscription after two minutes without us.
        parameters.RequestedMaxKeepAliveCount = max(1, round(5.0 / publish_s))
        parameters.RequestedLifetimeCount = max(3 * parameters.RequestedMaxKeepAliveCount, round(120.0 / publish_s))
        parameters.MaxNotificationsPerPublish = 20_000
        parameters.PublishingEnabled = True
        request = ua.CreateSubscriptionRequest()
        request.Parameters = parameters
        session = self.session
        data = await session._send_request(request)
        response = ua.ua_binary.struct_from_binary(ua.CreateSubscriptionResponse, data)
        response.ResponseHeader.ServiceResult.check()
        subscription = response.Parameters.SubscriptionId
        self._publishing = asyncio.create_task(self._publish(subscription, on_values, on_alive))
        return await self._monitor(subscription, nodes, sample_s, queue)

    async def _monitor(self, subscription: int, nodes: Mapping[int, Any], sample_s: float, queue: int) -> dict[int, int]:
        refused: dict[int, int] = {}
        places = list(nodes)
        # The time of the source counts as a change, so that a value that stays the same differs from a dead one.
        with_filter = True
        while places:
            again: list[int] = []
            for first in range(0, len(places), AT_ONCE):
                some = places[first : first + AT_ONCE]
                parameters = ua.CreateMonitoredItemsParameters()
                parameters.SubscriptionId = subscription
                parameters.TimestampsToReturn = ua.TimestampsToReturn.Both
                for index in some:
                    asked = ua.MonitoringParameters()
                    asked.ClientHandle = index
                    asked.SamplingInterval = 1000.0 * sample_s
                    asked.QueueSize = queue
                    asked.DiscardOldest = True
                    if with_filter:
                        asked.Filter = ua.DataChangeFilter(Trigger=ua.DataChangeTrigger.StatusValueTimestamp)
                    parameters.ItemsToCreate.append(
                        ua.MonitoredItemCreateRequest(
                            ItemToMonitor=ua.ReadValueId(NodeId=nodes[index], AttributeId=ua.AttributeIds.Value),
                            MonitoringMode=ua.MonitoringMode.Reporting,
                            RequestedParameters=asked,
                        )
                    )
                for index, result in zip(some, await self.session.create_monitored_items(parameters)):
                    code = result.StatusCode.value
                    if with_filter and code in NO_FILTER:
                        again.append(index)
                    elif code >= 0x8000_0000:
                        refused[index] = code
            places, with_filter = again, False
            if again:
                self.say(f"the server reports {len(again)} tags only when their values change, not when their times do")
        return refused

    async def _publish(
        self,
        subscription: int,
        on_values: Callable[[Sequence[tuple[int, Any]]], None],
        on_alive: Callable[[], None],
    ) -> None:
        """Asks for notifications until the connection ends. The exception has the reason."""
        session, expected = self.session, None
        acknowledged: list[Any] = []
        while True:
            response = await session.publish(acknowledged)
            acknowledged = []
            response.ResponseHeader.ServiceResult.check()
            result = response.Parameters
            if result.SubscriptionId != subscription:
                continue
            message = result.NotificationMessage
            data = message.NotificationData or []
            if expected is not None and message.SequenceNumber != expected:
                raise ConnectionError("the server skipped a notification")
            expected = message.SequenceNumber
            if data:
                expected = 1 if expected == 0xFFFF_FFFF else expected + 1
                acknowledged.append(
                    ua.SubscriptionAcknowledgement(SubscriptionId=subscription, SequenceNumber=message.SequenceNumber)
                )
            for each in data:
                if isinstance(each, ua.DataChangeNotification):
                    on_values([(item.ClientHandle, item.Value) for item in each.MonitoredItems])
                elif isinstance(each, ua.StatusChangeNotification):
                    raise ConnectionError(f"the server ended the subscription ({each.Status.name})")
            on_alive()

    def failed(self) -> BaseException | None:
        """The reason why notifications no longer arrive; None while notifications arrive."""
        if self._publishing is None or not self._publishing.done():
            return None
        if self._publishing.cancelled():
            return ConnectionError("the connection was closed")
        return self._publishing.exception()

    async def read(self, nodes: Mapping[int, Any]) -> dict[int, Any]:
        """The present values of nodes by index."""
        return dict(zip(nodes, await self._read(list(nodes.values()))))

    async def history(
        self, nodes: Mapping[int, Any], begin: int, end: int
    ) -> AsyncIterator[tuple[int, list[Any] | int | Unread]]:
        """Yield the recorded values of nodes in parts, or a status code if the server has no history of a node."""
        reading = Reading(
            list(nodes), begin, end, together=self._together, time_of=_time_of, key_of=lambda value: (_status_of(value), repr(value.Value))
        )
        until = time.monotonic() + MOST_S
        while spans := reading.next():
            if time.monotonic() > until:
                for span in [*spans, *reading.waiting]:
                    yield span.index, Unread(span.begin if span.high is None else span.high, span.end, f"the reading took more than {MOST_S / 60:.0f} min")
                return
            count = self._count
            for span, answer in zip(spans, await self._history([(nodes[span.index], span.point) for span in spans], *spans[0].asked)):
                for part in reading.take(span, answer, count):
                    yield span.index, part
            reading.together = self._together

    async def _history(self, asked: Sequence[tuple[Any, bytes | None]], begin: int, end: int) -> list[Answer]:
        """The server's answer about nodes, and the points at which the answer continues. If the server refuses the size of an
        answer, the request is repeated with a smaller size.
        """
        details = ua.ReadRawModifiedDetails()
        details.IsReadModified = False
        details.StartTime, details.EndTime = (EPOCH + timedelta(microseconds=at) for at in (begin, end))
        details.NumValuesPerNode = self._count
        # The last value before, which may still hold.
        details.ReturnBounds = self._bounds
        parameters = ua.HistoryReadParameters()
        parameters.HistoryReadDetails = details
        parameters.TimestampsToReturn = ua.TimestampsToReturn.Both
        parameters.ReleaseContinuationPoints = False
        parameters.NodesToRead = [ua.HistoryReadValueId(NodeId=node, ContinuationPoint=point) for node, point in asked]
        try:
            results = await self.session.history_read(parameters)
        except ua.UaStatusCodeError as error:
            if error.code in TOO_LARGE and len(asked) > 1:
                self._together = max(1, len(asked) // 2)
                halves = asked[: self._together], asked[self._together :]
                return [answer for half in halves for answer in await self._history(half, begin, end)]
            if error.code in TOO_LARGE and self._fewer():
                return await self._history(asked, begin, end)
            if error.code == ua.StatusCodes.BadBoundNotSupported and self._bounds:
                self._bounds = False
                return await self._history(asked, begin, end)
            if error.code not in NO_HISTORY:
                raise
            return [Answer(code=error.code) for _ in asked]
        if len(results) != len(asked):
            raise ConnectionError(f"the server answered about {len(results)} of {len(asked)} nodes")
        answers = []
        for (node, point), result in zip(asked, results):
            code = result.StatusCode.value
            if code == ua.StatusCodes.BadBoundNotSupported and self._bounds:
                self._bounds = False
                answers += await self._history([(node, point)], begin, end)
            elif code in TOO_LARGE and len(asked) == 1 and self._fewer():
                answers += await self._history([(node, point)], begin, end)
            elif code in TOO_LARGE or code == ua.StatusCodes.BadNoContinuationPoints:
                # The server may do it for fewer nodes at a time.
                self._together = max(1, min(self._together, len(asked) // 2))
                answers.append(Answer(code=code, retry=True))
            elif code in NO_DATA or code == ua.StatusCodes.BadContinuationPointInvalid and point is not None:
                answers.append(Answer())
            elif code >= 0x8000_0000:
                answers.append(Answer(code=code))
            else:
                values = getattr(result.HistoryData, "DataValues", None) or []
                answers.append(Answer(list(values), result.ContinuationPoint or None))
        return answers

    def _fewer(self) -> bool:
        """Requests half as many values per answer from now on, if possible."""
        if self._count <= 10:
            return False
        self._count //= 2
        return True


def _time_of(value: Any) -> int | None:
    at = value.SourceTimestamp or value.ServerTimestamp
    return None if at is None else microseconds(at)


def _status_of(value: Any) -> int:
    return 0 if value.StatusCode is None else int(value.StatusCode.value)


def _is_property(reference: Any) -> bool:
    kind = reference.ReferenceTypeId
    return bool(kind.NamespaceIndex == 0 and kind.Identifier == ua.ObjectIds.HasProperty)


def _first_certificate(data: bytes) -> bytes:
    """The first certificate of a chain (DER)."""
    if len(data) < 4 or data[0] != 0x30:
        raise Refused("the server has no certificate; make one on the server, or accept an open connection with --security none")
    if data[1] < 0x80:
        return data[: 2 + data[1]]
    count = data[1] & 0x7F
    return data[: 2 + count + int.from_bytes(data[2 : 2 + count], "big")]


def code_name(code: int) -> str:
    """The name of a status code."""
    return str(ua.StatusCode(code & 0xFFFF_0000).name)


def names_of(found: Iterable[Found], by_path: bool) -> dict[str, str]:
    """The nodes of variables, by name of the variable. A name that occurs twice is left out."""
    names: dict[str, str] = {}
    twice = set()
    for each in found:
        name = each.path if by_path else each.identifier
        if name in names:
            twice.add(name)
        elif name:
            names[name] = each.node
    return {name: node for name, node in names.items() if name not in twice}
