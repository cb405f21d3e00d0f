"""Messages of an editor: lenient headers, and one answer to bytes without a length."""

from __future__ import annotations

import io
import json
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.editor.message_stream import MOST_BYTES, MessageStream
from tests.editor.client import COMMAND, Client

BODY = b'{"jsonrpc": "2.0", "method": "x"}'


def message(body: bytes = BODY) -> bytes:
    return b"Content-Length: %d\r\n\r\n" % len(body) + body


def bodies(data: bytes) -> tuple[list[bytes], list[str]]:
    """Return the bodies that are read from bytes, and the errors sent for the remaining bytes."""
    answers = io.BytesIO()
    stream, read = MessageStream(io.BytesIO(data), answers), list[bytes]()
    while header := stream.readline():
        assert stream.readline() == b"\r\n"
        read.append(stream.read(int(header.removeprefix(b"Content-Length: "))))
    told, rest = list[str](), answers.getvalue()
    while rest:
        head, _, rest = rest.partition(b"\r\n\r\n")
        length = int(head.removeprefix(b"Content-Length: "))
        answer = json.loads(rest[:length])
        assert answer["id"] is None and answer["error"]["code"] == -32700
        told.append(answer["error"]["message"])
        rest = rest[length:]
    return read, told


@pytest.mark.parametrize(
    "header",
    [
        b"Content-Length: %d\r\n\r\n",
        b"content-length: %d\r\n\r\n",
        b"CONTENT-LENGTH:%d\r\n\r\n",
        b"Content-Length : %d\n\n",
        b"Content-Type: application/vscode-jsonrpc; charset=utf-8\r\nContent-Length: %d\r\n\r\n",
        b"Content-Length:\t%d \r\nContent-Type: x\r\n\r\n",
        b"\r\nContent-Length: %d\r\n\r\n",
    ],
)
def test_headers_in_any_spelling_are_read(header: bytes) -> None:
    data = header % len(BODY) + BODY
    assert bodies(data + data) == ([BODY, BODY], [])


@pytest.mark.parametrize(
    "lost",
    [
        BODY,
        BODY + b"\n",
        BODY + b"\r\n\r\n",
        b"Content-Type: x\r\n\r\n" + BODY,
        b"Content-Length: many\r\n\r\n" + BODY,
        b"Content-Length: -3\r\n\r\n",
        b"Content-Length: 0\r\n\r\n",
        b"Content-Length: %d\r\n\r\n" % (MOST_BYTES + 1) + BODY,
        b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"\x00\xff\n",
        json.dumps({"a": ["b"]}, indent=2).encode() + b"\n",
    ],
)
def test_bytes_without_a_length_are_answered_once_and_skipped(lost: bytes) -> None:
    read, told = bodies(message() + lost + message() + message())
    assert read == [BODY] * 3
    assert len(told) == 1 and "Content-Length" in told[0]


@given(st.lists(st.one_of(st.binary(max_size=40), st.just(message())), max_size=8))
def test_any_bytes_are_read_to_their_end(parts: list[bytes]) -> None:
    read, _ = bodies(b"".join(parts))
    assert len(read) <= sum(part.count(b"\n") + 1 for part in parts)


def test_server_goes_on_after_bytes_without_a_length(tmp_path: Path) -> None:
    pytest.importorskip("pygls")
    client = Client(tmp_path)
    client.send_bytes(BODY)
    path = tmp_path / "a.yaml"
    client.open(path, "kind: program\n")
    answer = client.receive()
    assert answer["error"]["code"] == -32700 and "Content-Length" in answer["error"]["message"]
    assert client.diagnostics(path)
    assert client.close() == 0


@pytest.mark.parametrize(
    ("body", "code", "number"),
    [
        (b"not json", -32700, None),
        (b"[" * 100_000, -32700, None),
        (b"\xff\xfe", -32700, None),
        (b"[1, 2]", -32600, None),
        (b'{"jsonrpc": "2.0", "id": 7}', -32600, None),
        (b'{"jsonrpc": "2.0", "id": 7, "method": "textDocument/hover"}', -32602, 7),
        (
            b'{"jsonrpc": "2.0", "id": "a", "method": "textDocument/hover", "params": {"position":'
            b' {"line": 0, "character": 4294967295}, "textDocument": {"uri": "file:///a.yaml"}}}',
            -32602,
            "a",
        ),
        (b'{"jsonrpc": "2.0", "id": 8, "method": "textDocument/hover", "params": [1]}', -32602, 8),
    ],
)
def test_server_answers_a_body_that_it_cannot_read(
    body: bytes, code: int, number: object, tmp_path: Path
) -> None:
    pytest.importorskip("pygls")
    client = Client(tmp_path)
    client.send_bytes(b"Content-Length: %d\r\n\r\n" % len(body) + body)
    answer = client.receive()
    assert (answer["error"]["code"], answer["id"]) == (code, number)
    path = tmp_path / "a.yaml"
    client.open(path, "kind: program\n")
    assert client.diagnostics(path)
    assert client.close() == 0


@pytest.mark.parametrize(
    "body",
    [
        b"{",
        b"[]",
        b"\xff\xfe\x00",
        b"[" * 100_000,
        b'{"jsonrpc": "2.0", "id": 5}',
        b'{"jsonrpc": "2.0", "id": 1.5, "method": "x\\u001b[2J"}',
        b'{"jsonrpc": "2.0", "id": 5, "method": "textDocument/hover", "params": {"position": 1}}',
        b'{"jsonrpc": "2.0", "id": 5, "method": "workspace/executeCommand",'
        b' "params": {"command": "nope"}}',
    ],
    ids=lambda body: body[-40:].decode("latin-1"),
)
def test_server_reports_a_faulty_message_in_lines_without_traceback(body: bytes) -> None:
    done = subprocess.run(
        COMMAND, input=message(body) + message(b'{"jsonrpc": "2.0", "method": "exit"}'),
        capture_output=True, check=False,
    )  # fmt: skip
    lines = done.stderr.decode().splitlines()
    assert lines and all(line.startswith("cb lsp: ") for line in lines), lines
    assert not any("Traceback" in line or "\x1b" in line for line in lines)
