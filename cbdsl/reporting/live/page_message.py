"""Message to pages: a kind, and JSON that is written when the first page needs it."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cached_property


class Message:
    """Message of the event stream of a live page.

    Args:
        kind: Name of the event.
        make: Function that returns the event's content, in JSON types. The first sender of the
            message calls it, so that the simulation does not wait for images to be packed.
    """

    def __init__(self, kind: str, make: Callable[[], object]) -> None:
        self.kind = kind
        self._make = make

    @cached_property
    def event(self) -> bytes:
        """Message as a server-sent event."""
        text = json.dumps(self._make(), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
        return f"event: {self.kind}\ndata: {text}\n\n".encode()


def message(kind: str, content: object) -> Message:
    """Return a message with constant content."""
    return Message(kind, lambda: content)
