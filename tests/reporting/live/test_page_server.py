"""The server: it serves this machine and its own page alone, and no client blocks it."""

from __future__ import annotations

import json
import re
import socket
import threading
import time
from collections.abc import Iterator, Mapping
from http.client import HTTPConnection, HTTPResponse
from typing import Any
from urllib.parse import quote, urlsplit

import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.reporting.live import page_server as module
from cbdsl.reporting.live.feed import Feed, message
from cbdsl.reporting.live.page_server import TOKEN, LiveServer
from cbdsl.reporting.live.requests import Requests
from cbdsl.reporting.live.transport import Transport

LONG = 20.0


class Served:
    """Server with its feed and transport."""

    def __init__(self) -> None:
        self.feed, self.transport = Feed(most=3), Transport()
        self.server = LiveServer(self.feed, self.page, Requests(self.transport))
        address = urlsplit(self.server.url)
        self.port, self.key = address.port, address.path.strip("/")
        self.host = f"127.0.0.1:{self.port}"

    def page(self, token: str) -> str:
        self.token = token
        return f"<title>{token}</title>"

    def ask(
        self, method: str, path: str, body: bytes | None = None, **headers: str
    ) -> HTTPResponse:
        return self.ask_at(f"/{self.key}{path}", method, body, **headers)

    def ask_at(
        self, path: str, method: str = "GET", body: bytes | None = None, **headers: str
    ) -> HTTPResponse:
        connection = HTTPConnection("127.0.0.1", self.port, timeout=LONG)
        named = {"Host": self.host} | {key.replace("_", "-"): each for key, each in headers.items()}
        connection.request(method, path, body, named)
        return connection.getresponse()

    def request(self, content: Any, token: str | None = None, **headers: str) -> tuple[int, Any]:
        shown = {TOKEN.replace("-", "_"): self.token if token is None else token}
        body = content if isinstance(content, bytes) else json.dumps(content).encode()
        answer = self.ask("POST", "/request", body, **shown, **headers)
        return answer.status, json.loads(answer.read())


@pytest.fixture
def served() -> Iterator[Served]:
    before = set(threading.enumerate())
    made = Served()
    yield made
    made.server.close()
    assert set(threading.enumerate()) == before


def events(answer: HTTPResponse) -> Iterator[tuple[str, Any]]:
    """Yield events of a stream as they arrive."""
    kind = ""
    while line := answer.readline().decode().rstrip("\n"):
        if line.startswith("event: "):
            kind = line[7:]
        elif line.startswith("data: "):
            yield kind, json.loads(line[6:])
            answer.readline()
        elif line.startswith(":"):
            answer.readline()


def test_page_has_an_unguessable_token(served: Served) -> None:
    answer = served.ask("GET", "/")
    assert (answer.status, answer.headers["Cache-Control"]) == (200, "no-store")
    assert answer.headers["X-Frame-Options"] == "DENY"
    assert answer.read().decode() == f"<title>{served.token}</title>"
    assert len(served.token) >= 32
    assert "cbdsl" in answer.headers["Server"] and "Python" not in answer.headers["Server"]


@pytest.mark.parametrize("place", ["", "events", "request"])
@pytest.mark.parametrize("key", ["", "x", "\xff", "{key}x", "x{key}", "{short}", "{key}%00"])
def test_page_without_the_key_of_its_address_is_refused(
    served: Served, key: str, place: str
) -> None:
    """Ask as another user of the machine, who knows the port from the list of connections."""
    assert len(served.key) >= 32 and served.key != served.token
    given = key.format(key=served.key, short=served.key[:-1])
    for path in dict.fromkeys((f"/{given}/{place}", f"/{place}")):
        answer = served.ask_at(quote(path, safe="/%"))
        content = answer.read().decode()
        assert answer.status == 404
        assert served.token not in content and served.key not in content
        token = {TOKEN.replace("-", "_"): served.token}
        assert (
            served.ask_at(quote(path, safe="/%"), "POST", b'{"do": "pause"}', **token).status == 404
        )
    assert not served.transport.paused


def test_server_listens_on_the_loopback_address(served: Served) -> None:
    assert served.server._http.server_address[0] == "127.0.0.1"


@pytest.mark.parametrize("path", ["/", "/events", "/request", "/other"])
@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": "127.0.0.1"},
        {"Host": "127.0.0.1.evil.example:{port}"},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
    ],
    ids=str,
)
def test_foreign_hosts_and_origins_are_refused(
    served: Served, path: str, headers: Mapping[str, str]
) -> None:
    sent = {key: value.format(port=served.port) for key, value in headers.items()}
    assert served.ask("GET", path, **sent).status == 403
    token = {TOKEN.replace("-", "_"): served.token}
    assert served.ask("POST", path, b'{"do": "pause"}', **token, **sent).status == 403
    assert not served.transport.paused


def test_localhost_is_this_machine_too(served: Served) -> None:
    name = f"localhost:{served.port}"
    assert served.ask("GET", "/", Host=name, Origin=f"http://{name}").status == 200


def test_request_without_the_token_is_refused(served: Served) -> None:
    for token in ("", "x", served.token[:-1]):
        assert served.request({"do": "pause"}, token)[0] == 403
    assert not served.transport.paused
    assert served.request({"do": "pause"})[0] == 200
    assert served.transport.paused


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "JSON object"),
        (b"[" * 5000, "JSON object"),
        (b"\xff", "JSON object"),
        ([1], "JSON object"),
        (b" " * 70000, "65536 bytes"),
        ({}, "known: pause"),
        ({"do": "paus"}, "did you mean 'pause'"),
        ({"do": ["pause"]}, "known: pause"),
        ({"do": "step", "ticks": 0}, "from 1 to 1000"),
        ({"do": "step", "ticks": True}, "from 1 to 1000"),
        ({"do": "speed", "value": 0}, "from 0.01 to 100"),
        ({"do": "speed", "value": "1"}, "not a number"),
        (b'{"do": "speed", "value": NaN}', "not a number"),
        (b'{"do": "speed", "value": 1%s}' % (b"0" * 400), "not a number"),
        (b'{"do": "speed", "value": -1%s}' % (b"0" * 400), "not a number"),
        (b'{"do": "\\ud800"}', "known: pause"),
    ],
    ids=str,
)
def test_invalid_request_is_refused_with_a_reason(served: Served, content: Any, words: str) -> None:
    status, answer = served.request(content)
    assert status == 409
    assert words in answer["problem"]


@pytest.mark.parametrize(
    "value", ["1" + "0" * 400, "1e999", "-1e999", "NaN", '"\\ud800"', "[[[[]]]]"]
)
@pytest.mark.parametrize("key", ["do", "value", "ticks", "name", "stack"])
def test_request_with_an_odd_value_has_an_answer(served: Served, key: str, value: str) -> None:
    doing = ("play", "speed", "step", "compose")
    requests = [f'{{"do": "{do}", "{key}": {value}}}' for do in doing]
    for request in (*requests, f'{{"{key}": {value}}}', value):
        status, answer = served.request(request.encode("utf-8", "surrogatepass"))
        assert status in (200, 400, 409) and isinstance(answer, dict)


@pytest.mark.parametrize(
    ("length", "words"),
    [
        ("9" * 5000, "65536 bytes"),
        ("-3", "65536 bytes"),
        ("\u00b2", "65536 bytes"),
        ("50", "shorter"),
    ],
)
def test_request_with_an_odd_length_has_an_answer(
    served: Served, length: str, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module._Handler, "timeout", 0.2)
    head = (
        f"POST /{served.key}/request HTTP/1.1\r\nHost: {served.host}\r\n{TOKEN}: {served.token}\r\n"
    )
    with socket.create_connection(("127.0.0.1", served.port), timeout=LONG) as client:
        client.sendall(f"{head}Content-Length: {length}\r\n\r\n{{}}".encode("latin-1"))
        assert words in client.makefile("rb").read().decode()


def test_unknown_paths_and_methods_are_refused(served: Served) -> None:
    assert served.ask("GET", "/../../etc/passwd").status == 404
    assert served.ask("PUT", "/").status == 501
    shown = {TOKEN.replace("-", "_"): served.token}
    assert served.ask("POST", "/events", b"{}", **shown).status == 404


def test_two_pages_receive_the_same_messages(served: Served) -> None:
    served.feed.begin(message("episode", {"seed": 7}))
    streams = [events(served.ask("GET", "/events")) for _ in range(2)]
    assert [next(each) for each in streams] == [("episode", {"seed": 7})] * 2
    served.feed.append(message("transition", {"state": "◁"}))
    assert [next(each) for each in streams] == [("transition", {"state": "◁"})] * 2


def test_page_too_many_is_refused(served: Served) -> None:
    served.feed.begin(message("episode", {}))
    open_ = [served.ask("GET", "/events") for _ in range(3)]
    assert served.ask("GET", "/events").status == 503
    assert all(each.status == 200 for each in open_)


def test_client_that_reads_nothing_does_not_delay_others(served: Served) -> None:
    served.feed.begin(message("episode", {}))
    idle = socket.create_connection(("127.0.0.1", served.port))
    idle.sendall(f"GET /{served.key}/events HTTP/1.0\r\nHost: {served.host}\r\n\r\n".encode())
    stream = events(served.ask("GET", "/events"))
    assert next(stream) == ("episode", {})
    large = "x" * 100_000
    slowest = 0.0
    for number in range(300):
        began = time.perf_counter()
        served.feed.renew(message("frame", {"number": number, "filling": large}))
        slowest = max(slowest, time.perf_counter() - began)
        time.sleep(0.001)
    numbers = []
    for kind, content in stream:
        if kind == "frame":
            numbers.append(content["number"])
        if numbers and numbers[-1] == 299:
            break
    assert numbers == sorted(set(numbers))
    assert slowest < 1.0  # a full socket would have blocked it for ten
    idle.close()


def test_closing_reports_pages_and_gives_the_port_back() -> None:
    served = Served()
    served.feed.begin(message("episode", {}))
    stream = events(served.ask("GET", "/events"))
    next(stream)
    idle = socket.create_connection(("127.0.0.1", served.port))  # never sends a request
    began = time.monotonic()
    served.server.close()
    assert time.monotonic() - began < 5.0
    assert [kind for kind, _ in stream] == ["closed"]
    again = LiveServer(Feed(), lambda token: "", Requests(Transport()), served.port)
    again.close()
    idle.close()


def test_taken_port_names_a_free_one(served: Served) -> None:
    with pytest.raises(UsageError, match=f"--live-port {served.port}: another program") as caught:
        LiveServer(Feed(), lambda token: "", Requests(Transport()), served.port)
    free = int(re.search(r"; (\d+) is free", str(caught.value))[1])  # type: ignore[index]
    LiveServer(Feed(), lambda token: "", Requests(Transport()), free).close()
