"""Messages of an editor, with lenient headers and an answer to bytes without one."""

from __future__ import annotations

import json
import re
from typing import BinaryIO

# Header fields are case-insensitive, and spaces around their values have no meaning.
_LENGTH = re.compile(rb"content-length[ \t]*:[ \t]*(\d+)\s*$", re.IGNORECASE)
_FIELD = re.compile(rb"[!#$%&'*+.^_`|~0-9A-Za-z-]+[ \t]*:")
_LONGEST_LINE = 1 << 20
#: Bytes of the largest message that is read; a document is far smaller.
MOST_BYTES = 1 << 28
_PARSE_ERROR, _INVALID_REQUEST, _INVALID_PARAMETERS = -32700, -32600, -32602


class MessageStream:
    """Input of a language server, in which each message has a proper header.

    Bytes without a header are answered with one error, and skipped up to the next header.

    Args:
        source: Bytes of the editor.
        answers: Stream on which the editor reads answers.
    """

    def __init__(self, source: BinaryIO, answers: BinaryIO) -> None:
        self._source, self._answers = source, answers
        self._rest: list[bytes] = []
        self._is_skipping = False
        self._body = b""

    def readline(self) -> bytes:
        """Return the next line of a header; empty at the end of the input."""
        if not self._rest:
            length = self._next_length()
            if length is None:
                return b""
            self._rest = [b"Content-Length: %d\r\n" % length, b"\r\n"]
        return self._rest.pop(0)

    def read(self, size: int) -> bytes:
        """Return the body of a message."""
        self._body = self._source.read(size)
        return self._body

    def refuse_body(self) -> None:
        """Answer that the last message is not JSON, or that its parameters are invalid.

        A notification has no answer.
        """
        try:
            message = json.loads(self._body)
        except (ValueError, RecursionError):
            self._answer(None, _PARSE_ERROR, "a message cannot be read: it is not JSON")
            return
        if not isinstance(message, dict) or "method" not in message:
            self._answer(None, _INVALID_REQUEST, "a message is no request: it has no 'method'")
        elif "id" in message:
            reason = f"the parameters of {message['method']} are not those of the protocol"
            self._answer(message["id"], _INVALID_PARAMETERS, reason)

    def _next_length(self) -> int | None:
        """Return the length of the next message; ``None`` at the end of the input."""
        length: int | None = None
        while line := self._source.readline(_LONGEST_LINE):
            match = _LENGTH.search(line)
            if match:
                length = int(match[1])
                if match.start() > 0:  # after a body without a header
                    self._refuse("it has no header 'Content-Length: BYTES'")
            elif not line.strip():
                if length is not None and 0 < length <= MOST_BYTES:
                    self._is_skipping = False
                    return length
                if length is not None:
                    self._refuse(f"its Content-Length is {length}, not 1 to {MOST_BYTES}")
                length = None
            elif not _FIELD.match(line) or line.lower().startswith(b"content-length"):
                self._refuse("it has no header 'Content-Length: BYTES'")
        return None

    def _refuse(self, reason: str) -> None:
        """Answer that a message cannot be read, once for all bytes up to the next header."""
        if self._is_skipping:
            return
        self._is_skipping = True
        self._answer(None, _PARSE_ERROR, f"a message cannot be read: {reason}")

    def _answer(self, number: object, code: int, reason: str) -> None:
        """Answer a request, or a message without a number, with an error."""
        error = {"code": code, "message": reason}
        body = json.dumps({"jsonrpc": "2.0", "id": number, "error": error}).encode()
        self._answers.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self._answers.flush()
