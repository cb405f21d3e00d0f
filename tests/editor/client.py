"""Test client: an editor that runs the real language server over its streams."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

COMMAND = [sys.executable, "-c", "from cbdsl.cli.main import main; main()", "lsp"]


class Client:
    """Editor with one open document.

    Attributes:
        published: Diagnostics received last, by URI.
    """

    def __init__(self, folder: Path, encodings: Sequence[str] | None = None) -> None:
        self._process = subprocess.Popen(
            COMMAND, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        self._number = 0
        self._version = 0
        self.published: dict[str, list[dict[str, Any]]] = {}
        general = {} if encodings is None else {"general": {"positionEncodings": encodings}}
        options = {"processId": None, "rootUri": folder.as_uri(), "capabilities": general}
        self.capabilities = self.ask("initialize", options)["capabilities"]
        self.tell("initialized", {})

    def tell(self, method: str, params: Mapping[str, Any]) -> None:
        """Send a notification."""
        self._send({"method": method, "params": params})

    def ask(self, method: str, params: Mapping[str, Any]) -> Any:
        """Send a request and return its result, after reading all earlier messages."""
        message = self._answer(method, params)
        assert "error" not in message, message["error"]
        return message["result"]

    def refused(self, method: str, params: Mapping[str, Any]) -> str:
        """Send a request that is refused, and return the error message."""
        told: str = self._answer(method, params)["error"]["message"]
        return told

    def _answer(self, method: str, params: Mapping[str, Any]) -> dict[str, Any]:
        self._number += 1
        self._send({"id": self._number, "method": method, "params": params})
        while True:
            message = self._receive()
            if message.get("method") == "textDocument/publishDiagnostics":
                self.published[message["params"]["uri"]] = message["params"]["diagnostics"]
            if message.get("id") == self._number:
                return message

    def open(self, path: Path, text: str) -> None:
        self.open_uri(path.as_uri(), text)

    def open_uri(self, uri: str, text: str) -> None:
        """Open a document that may be in no file."""
        document = {"uri": uri, "languageId": "yaml", "version": 0, "text": text}
        self.tell("textDocument/didOpen", {"textDocument": document})

    def change(self, path: Path, text: str) -> None:
        self._version += 1
        document = {"uri": path.as_uri(), "version": self._version}
        changes = {"textDocument": document, "contentChanges": [{"text": text}]}
        self.tell("textDocument/didChange", changes)

    def at(self, method: str, path: Path, line: int, character: int) -> Any:
        """Send a request about a place."""
        position = {"line": line, "character": character}
        place = {"textDocument": {"uri": path.as_uri()}, "position": position}
        return self.ask(f"textDocument/{method}", place)

    def diagnostics(self, path: Path) -> list[dict[str, Any]]:
        """Return the diagnostics of a document, after the server has answered a later request."""
        self.at("hover", path, 0, 0)
        return self.published[path.as_uri()]

    def send_bytes(self, data: bytes) -> None:
        """Write bytes that may be no message."""
        assert self._process.stdin is not None
        self._process.stdin.write(data)
        self._process.stdin.flush()

    def receive(self) -> dict[str, Any]:
        """Return the next message of the server."""
        return self._receive()

    def close(self) -> int:
        """End the server as editors do, and return its exit code."""
        self.ask("shutdown", {})
        self.tell("exit", {})
        assert self._process.stdin is not None
        self._process.stdin.close()
        return self._process.wait(timeout=20)

    def _send(self, message: Mapping[str, Any]) -> None:
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.send_bytes(b"Content-Length: %d\r\n\r\n" % len(body) + body)

    def _receive(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        length = 0
        while line := self._process.stdout.readline().strip():
            name, _, value = line.partition(b":")
            if name.lower() == b"content-length":
                length = int(value)
        assert length, "the server ended"
        message: dict[str, Any] = json.loads(self._process.stdout.read(length))
        return message
