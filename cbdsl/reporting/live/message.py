"""A message to pages: a kind, and JSON that is written when the first page needs it."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cached_property


class Message:
    """Message of the event stream of a live page.

    Args:
        kind: name of the event.
        make: gives what the event tells, as JSON has it; it is called by whoever sends the message
            first, so that the simulation waits for no image to be packed.
    """

    def __init__(self, kind: str, make: Callable[[], object]) -> None:
        self.kind = kind
        self._make = make

    @cached_property
    def event(self) -> bytes:
        """The message as a server-sent event."""
        text = json.dumps(self._make(), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
        return f"event: {self.kind}\ndata: {text}\n\n".encode()


def message(kind: str, content: object) -> Message:
    """A message whose content is known already, and stays as it is."""
    return Message(kind, lambda: content)
