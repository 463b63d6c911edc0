"""The client of OPC UA servers only reads, and trusts only what it was told to."""

import asyncio
import inspect
import ipaddress
import random
import socket
import re
from datetime import datetime, timedelta, timezone

import pytest

pytest.importorskip("asyncua")

from asyncua import ua
from asyncua.crypto import cert_gen
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding
from cryptography.x509.oid import ExtendedKeyUsageOID
from stiction.live import opcua, tags
from stiction.live.errors import Refused

REQUESTS = sorted(
    (kind for name, kind in vars(ua).items() if inspect.isclass(kind) and re.fullmatch(r"[A-Za-z0-9]+Request", name) and hasattr(kind, "RequestHeader")),
    key=lambda kind: kind.__name__,
) or sorted({kind for name, kind in vars(ua).items() if inspect.isclass(kind) and name.endswith("Request") and "RequestHeader" in getattr(kind, "__annotations__", {})}, key=lambda kind: kind.__name__)


class Wire:
    """Stands for the connection, and keeps what is written to it."""

    def __init__(self):
        self.written = []

    def write(self, data):
        self.written.append(data)


def sent(request):
    """The bytes that a request puts on the wire."""

    async def send():
        client = opcua.ReadOnlyClient("opc.tcp://127.0.0.1:4840", 1.0)
        protocol = client.uaclient._make_protocol()
        protocol.transport = wire = Wire()
        try:
            protocol._send_request(request)
        finally:
            protocol.transport = None
        return wire.written

    return asyncio.run(send())


def test_all_services_are_known():
    names = {kind.__name__ for kind in REQUESTS}
    assert {"WriteRequest", "CallRequest", "AddNodesRequest", "DeleteNodesRequest", "HistoryUpdateRequest", "ReadRequest"} <= names
    assert len(names) >= 35 and opcua.SERVICES <= set(REQUESTS)


@pytest.mark.parametrize("kind", [kind for kind in REQUESTS if kind not in opcua.SERVICES], ids=lambda kind: kind.__name__)
def test_a_service_that_is_not_listed_is_refused_before_a_byte_is_sent(kind, monkeypatch):
    written = []
    monkeypatch.setattr(Wire, "write", lambda _self, data: written.append(data))
    with pytest.raises(Refused, match=f"{kind.__name__} was not sent"):
        sent(kind())
    assert written == []


@pytest.mark.parametrize("kind", sorted(opcua.SERVICES, key=lambda kind: kind.__name__), ids=lambda kind: kind.__name__)
def test_what_is_listed_reads(kind):
    # A list that grew by mistake would show here.
    assert not re.search(r"Write|Call|Add|Update|Register|Transfer|Cancel|DeleteNodes|DeleteRef|SetTrigger|SetMonitoring", kind.__name__)


def test_a_listed_service_is_sent():
    assert len(sent(ua.ReadRequest())) == 1


def test_a_subclass_of_a_listed_service_is_refused():
    class Sly(ua.ReadRequest):
        pass

    with pytest.raises(Refused):
        sent(Sly())


async def _every_way_to_write(client):
    node = client.get_node("ns=2;i=1")
    yield node.write_value(1.0)
    yield node.call_method("2:Start")
    yield client.delete_nodes([node])
    yield client.register_namespace("urn:a")
    yield node.add_variable(2, "new", 1.0)
    yield client.write_values([node], [1.0])
    yield client.register_nodes([node])
    yield client.uaclient.session.history_update(ua.HistoryUpdateParameters())


def test_no_method_of_the_library_writes(live):
    server = live.serve("--no-history")

    async def attempt():
        client = opcua.ReadOnlyClient(live.url, 5.0)
        await client.connect()
        try:
            count = 0
            async for way in _every_way_to_write(client):
                with pytest.raises((Refused, ua.UaError, TypeError)):
                    await way
                count += 1
            return count
        finally:
            await client.disconnect()

    assert asyncio.run(attempt()) == 8
    server.tell("requests")
    asked = server.answer("requests")["requests"]
    known = {kind.__name__ for kind in opcua.SERVICES}
    assert set(asked) <= known and asked["ReadRequest"] >= 1


HOSTS = (x509.DNSName("Plant-Server"), x509.IPAddress(ipaddress.ip_address("fd00::1")))


def certificate(uri="urn:server", days=10, hosts=HOSTS):
    key = cert_gen.generate_private_key()
    made = cert_gen.generate_self_signed_app_certificate(key, "server", {}, [x509.UniformResourceIdentifier(uri), *hosts], [ExtendedKeyUsageOID.SERVER_AUTH], days)
    return made.public_bytes(Encoding.DER)


def test_an_unknown_certificate_is_refused_kept_and_trusted_when_it_was_moved(tmp_path):
    data, security = certificate(), opcua.Security(folder=tmp_path)
    with pytest.raises(Refused, match="is not trusted; compare the SHA-256") as refused:
        opcua.check_certificate(data, "urn:server", "plant-server", security)
    assert opcua.fingerprint(data) in str(refused.value)
    [kept] = (tmp_path / "rejected").iterdir()
    (tmp_path / "trusted").mkdir()
    kept.rename(tmp_path / "trusted" / kept.name)
    assert opcua.check_certificate(data, "urn:server", "plant-server", security) is None
    with pytest.raises(Refused, match="not trusted"):
        opcua.check_certificate(certificate(), "urn:server", "plant-server", security)


def test_the_first_certificate_is_trusted_only_on_request_and_no_second_one(tmp_path):
    security = opcua.Security(folder=tmp_path, trust_first=True)
    data = certificate()
    assert "trusted from now on" in opcua.check_certificate(data, "urn:server", "plant-server", security)
    assert opcua.check_certificate(data, "urn:server", "plant-server", security) is None
    with pytest.raises(Refused, match="not trusted"):
        opcua.check_certificate(certificate(), "urn:server", "plant-server", security)


def test_expired_and_foreign_certificates_are_refused_even_if_trusted(tmp_path):
    security = opcua.Security(folder=tmp_path, trust_first=True)
    with pytest.raises(Refused, match="is valid from .* today is"):
        opcua.check_certificate(certificate(days=0), "urn:server", "plant-server", security)
    with pytest.raises(Refused, match="is for urn:other, but the server is urn:server"):
        opcua.check_certificate(certificate("urn:other"), "urn:server", "plant-server", security)


def test_the_names_in_a_certificate_are_compared_unless_it_is_reported_otherwise(tmp_path):
    security, said = opcua.Security(folder=tmp_path, trust_first=True), []
    here = certificate(hosts=[x509.DNSName(socket.gethostname())])
    for data, host in [(certificate(), "other"), (certificate(hosts=()), "plant-server"), (here, "plant-server"), (certificate(), "fd00::2")]:
        with pytest.raises(Refused, match=f"but the address names {host}; name the host as the certificate does, .* accept any name with --any-name"):
            opcua.check_certificate(data, "urn:server", host, security)
    assert not (tmp_path / "trusted").exists(), "a wrong name is not trusted first"
    for data, host in [(certificate(), "PLANT-server."), (certificate(), "fd00:0::1"), (here, "localhost"), (here, "127.0.0.1")]:
        opcua.check_certificate(data, "urn:server", host, opcua.Security(folder=tmp_path / opcua.fingerprint(data), trust_first=True))
    known = opcua.Security(folder=tmp_path, trust_first=True, any_name=True)
    opcua.check_certificate(certificate("urn:other", hosts=()), "urn:server", "other", known)
    server = opcua.Server("opc.tcp://other:4840", known, say=said.append)
    server._say_any_name()
    assert server.host == "other" and said == ["the names in the server's certificate were not compared, because --any-name was given"]


def signed(issuer_ca, days=10, signs=None):
    """A certificate of a server and that of its issuer."""
    from cryptography.hazmat.primitives import hashes
    from cryptography.hazmat.primitives.asymmetric import rsa
    from cryptography.x509.oid import NameOID

    now = datetime.now(timezone.utc)

    def made(name, issuer, key, signer, more, days):
        builder = x509.CertificateBuilder().subject_name(name).issuer_name(issuer).public_key(key.public_key())
        builder = builder.serial_number(x509.random_serial_number()).not_valid_before(now - timedelta(days=20)).not_valid_after(now + timedelta(days=days))
        for each in more:
            builder = builder.add_extension(each, critical=False)
        return builder.sign(signer, hashes.SHA256())

    name = lambda text: x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, text)])  # noqa: E731
    own, key = (rsa.generate_private_key(public_exponent=65537, key_size=2048) for _ in range(2))
    basic = [] if issuer_ca is None else [x509.BasicConstraints(ca=issuer_ca, path_length=None)]
    uses = ("digital_signature", "content_commitment", "key_encipherment", "data_encipherment", "key_agreement", "crl_sign", "encipher_only", "decipher_only")
    basic += [] if signs is None else [x509.KeyUsage(**dict.fromkeys(uses, False), key_cert_sign=signs)]
    issuer = made(name("issuer"), name("issuer"), own, own, basic, days)
    leaf = made(name("server"), name("issuer"), key, own, [x509.SubjectAlternativeName([x509.UniformResourceIdentifier("urn:server"), *HOSTS])], 10)
    return leaf.public_bytes(Encoding.DER), issuer.public_bytes(Encoding.DER)


NO_AUTHORITY = "not the certificate of an authority"


@pytest.mark.parametrize(
    ("is_ca", "days", "signs", "words"),
    [(True, 10, None, None), (True, 10, True, None), (True, 10, False, NO_AUTHORITY), (False, 10, None, NO_AUTHORITY), (None, 10, None, NO_AUTHORITY),
     (None, 10, True, NO_AUTHORITY), (True, -5, None, "signed it, but is valid from")],
)  # fmt: skip
def test_only_a_valid_authority_vouches_for_a_server(tmp_path, is_ca, days, signs, words):
    leaf, issuer = signed(is_ca, days, signs)
    (tmp_path / "trusted").mkdir()
    (tmp_path / "trusted/issuer.der").write_bytes(issuer)
    (tmp_path / "trusted/junk.der").write_bytes(b"junk")
    if words is None:
        # A junk file is named, whoever is trusted.
        assert "junk.der is not a certificate; remove the file" in opcua.check_certificate(leaf, "urn:server", "plant-server", opcua.Security(folder=tmp_path))
    else:
        with pytest.raises(Refused, match=words) as refused:
            opcua.check_certificate(leaf, "urn:server", "plant-server", opcua.Security(folder=tmp_path))
        assert "junk.der is not a certificate; remove the file" in str(refused.value)


def test_a_password_goes_only_to_a_trusted_certificate_also_on_an_open_channel(tmp_path):
    class Policy:
        SecurityPolicyUri, PolicyId = opcua.POLICIES["Basic256Sha256"].URI, "1"

    class Plain:
        SecurityPolicyUri, PolicyId = None, "1"

    async def attempt(security, policy=Policy, password="Pa55"):
        own = opcua.Server("opc.tcp://plant-server:1", security, say=lambda _: None)
        client = opcua.ReadOnlyClient(own.url, 1.0)
        client.check_peer = lambda: own._check_peer(client)
        client.server_policy = lambda _: policy
        client.security_policy.peer_certificate = certificate()
        client._server_nonce = b"n" * 32
        parameters = ua.ActivateSessionParameters()
        client._add_user_auth(parameters, "me", password)
        return parameters.UserIdentityToken.Password

    with pytest.raises(Refused, match="the user and the password were not sent, because the certificate of the server .* is not trusted"):
        asyncio.run(attempt(opcua.Security(folder=tmp_path)))
    assert b"Pa55" not in asyncio.run(attempt(opcua.Security(folder=tmp_path, trust_first=True)))
    for password in ("Pa55", None):
        with pytest.raises(Refused, match="the user and the password unencrypted, so they were not sent"):
            asyncio.run(attempt(opcua.Security(folder=tmp_path), Plain, password))


def test_a_certificate_is_made_once_with_a_private_key(tmp_path):
    opcua.make_certificate(tmp_path)
    assert (tmp_path / "client.pem").stat().st_mode & 0o077 == 0
    made = x509.load_der_x509_certificate((tmp_path / "client.der").read_bytes())
    assert made.not_valid_after_utc > datetime.now(timezone.utc) + timedelta(days=1000)
    with pytest.raises(Refused, match="exists already"):
        opcua.make_certificate(tmp_path)


def test_addresses_with_secrets_and_others_are_refused():
    for url, words in [
        ("opc.tcp://me:secret@host:4840", "STICTION_OPCUA_PASSWORD"),
        ("opc.tcp://me:a/secret@host:4840", "STICTION_OPCUA_PASSWORD"),
        ("opc.tcp://host:port", "not the address of an OPC UA server"),
        ("http://host:4840", "not the address of an OPC UA server"),
        ("opc.tcp://", "not the address"),
    ]:
        with pytest.raises(Refused, match=words) as refused:
            opcua.Server(url, opcua.Security(), say=print)
        assert "secret" not in str(refused.value)


def test_tags_are_read_with_the_line_of_a_fault(tmp_path):
    path = tmp_path / "live.toml"
    known = {'FIC"1.PV': "nsu=urn:plant;s=FIC1.PV", "Ä.OP": "ns=2;i=7"}
    path.write_text(tags.text_of(known, "opc.tcp://host"), encoding="utf-8")
    assert tags.read(path) == known
    for text, words in [
        ('[tags]\n"A" = 7', "line 2: write"),
        ('"A" = "B"', "line 1: write"),
        ("[other]", r"line 1: \[other\] is not known"),
        ('[tags]\n"A" = "x"\n"A" = "y"', "line 3: A is listed twice"),
    ]:
        path.write_text(text)
        with pytest.raises(Refused, match=words):
            tags.read(path)


def test_tags_with_any_letters_are_read_as_they_were_written(tmp_path):
    own, path = random.Random(1), tmp_path / "live.toml"
    letters = [chr(k) for k in range(0x20)] + list('{}"\'%=#[]\\ \x7f\x85\u2028\u2029\ufeff\u00e4\u0130\U0001f600aA') + ["\r\n"]
    known = {"".join(own.choices(letters, k=own.randrange(1, 9))): f"s={k}" for k in range(10_000)}
    path.write_text(tags.text_of(known, "opc.tcp://host"), encoding="utf-8")
    assert tags.read(path) == known


def test_words_of_modes_come_from_the_plant():
    assert tags.mode_words('name = "N"\n[modes]\n"3" = "auto"\nHand = "manual"\n"Auto 2" = "auto" # x\n[area.A]\nB = "auto"') == {"hand": 0.0, "auto 2": 1.0}
