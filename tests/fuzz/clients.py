"""User input: edits in an editor, requests of a live page, and words of commands."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path

from cbdsl.api.requests.explored_actions import read_action
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.diagnostics.errors import UsageError
from cbdsl.editor.buffers import Buffers
from cbdsl.editor.coloring import colored_words
from cbdsl.editor.completions import choices
from cbdsl.editor.cursor import cursor
from cbdsl.editor.fixes import fixed
from cbdsl.editor.hover import hover
from cbdsl.editor.keys import keys
from cbdsl.editor.language_server import definition
from cbdsl.editor.rename import renaming
from cbdsl.reporting.live.page_server import RequestError
from cbdsl.reporting.live.requests import Requests
from cbdsl.reporting.live.transport import Transport
from tests.conftest import ROOT
from tests.editor.test_random_edits import PIECES
from tests.fuzz.entry_point import EntryPoint

_PROGRAMS = sorted((ROOT / "programs").glob("*.yaml"))
_EDITS, _EDIT = 6, 5


@cache
def _buffers() -> Buffers:
    return Buffers(ROOT)


def _edits(data: bytes) -> None:
    """Edit a shipped document; each five bytes give the place, the deleted length and the text."""
    buffers = _buffers()
    path = _PROGRAMS[data[0] % len(_PROGRAMS) if data else 0]
    text, path = _text(path), Path("/nowhere") / path.name
    at = where = 0
    for start in range(1, min(len(data), 1 + _EDITS * _EDIT), _EDIT):
        high, low, length, piece, where = data[start : start + _EDIT].ljust(_EDIT, b"\0")
        at = (256 * high + low) % (len(text) + 1)
        # The upper pieces are copies of text elsewhere in the document.
        elsewhere = 16 * where
        new = PIECES[piece] if piece < len(PIECES) else text[elsewhere : elsewhere + piece]
        text = text[:at] + new + text[at + length % 64 :]
        buffers.change(path, text)
    # Requests follow the last edit alone: a prefix of the input asks after an earlier one.
    _ask(buffers, path, text, at + where % 8, rename=where % 16 == 0)


@cache
def _text(path: Path) -> str:
    return path.read_text("utf-8")[:4000]


def _ask(buffers: Buffers, path: Path, text: str, at: int, *, rename: bool) -> None:
    """Send all requests that an editor makes at a place."""
    buffers.change(path, text)
    lines = text.splitlines()
    fixed(text, buffers.diagnostics(path))
    before = text[:at].splitlines() or [""]
    place = cursor(lines, len(before) - 1, len(before[-1]))
    choices(buffers, path, place.steps)
    keys(text, place.steps)
    hover(buffers, path, place)
    definition(buffers, path, place)
    list(colored_words(buffers, path))
    if rename:
        renaming(buffers, path, place)


def _page_request(data: bytes) -> None:
    """Answer a request, which the server has read as a JSON object."""
    with suppress(ValueError, RecursionError):
        request = json.loads(data)
        if isinstance(request, dict):
            try:
                Requests(Transport(math.inf))(request)
            except RequestError as error:
                str(error).encode("utf-8", "surrogatepass")


def _command_line(data: bytes) -> None:
    texts = data.decode("utf-8", "replace").split("\n")
    for read in (lambda: read_assignments(texts), lambda: read_action(texts[0])):
        with suppress(UsageError):
            read()


def _requests() -> Iterator[bytes]:
    for request in (
        *({"do": "pause"}, {"do": "step", "ticks": 3}, {"do": "speed", "value": 0.5}),
        *({"do": "speed", "value": None}, {"do": "gain", "controller": "a", "value": 1}),
    ):
        yield json.dumps(request).encode()


def _words() -> Iterator[bytes]:
    yield from (b"reach", b"a=reach:feature=red", b"visualinspect:mark=?", b"arm=left_arm\nx=1 m")


ENTRY_POINTS = {
    "edits": EntryPoint(_edits, lambda: (bytes([k, 0, 40 * k % 256, 3, k, 7]) for k in range(60))),
    "page_request": EntryPoint(_page_request, _requests),
    "command_line": EntryPoint(_command_line, _words),
}
