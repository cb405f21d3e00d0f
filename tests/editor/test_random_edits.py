"""Random edits: the server answers the editor's requests after each of them."""

from __future__ import annotations

import random
from contextlib import suppress
from pathlib import Path

import pytest

from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.editor.buffers import Buffers
from cbdsl.editor.coloring import colored_words
from cbdsl.editor.completions import choices
from cbdsl.editor.cursor import cursor
from cbdsl.editor.fixes import fixed
from cbdsl.editor.hover import hover
from cbdsl.editor.keys import keys
from cbdsl.editor.language_server import definition
from cbdsl.editor.rename import renaming
from cbdsl.yaml_text.reader import formatted_text
from tests.conftest import ROOT

PROGRAMS = sorted((ROOT / "programs").glob("*.yaml"))
PIECES = [
    *("{", "}", "[", "]", ":", ": ", ", ", "\n", "\n  ", "'", '"', "#", "$", "&a ", "*a", "!x "),
    *("\t", "\r", "\x00", "\u2028", "\U0001f600", "◁", "- ", "? ", "|", ">-", "%", "---\n"),
    *("potential", "spring", "head.uniform", "controllers:", "kind: robot", "1e999", "-", "0 deg"),
]


def edited(text: str, rng: random.Random) -> str:
    """Return the text with a part cut out, copied, or typed into it."""
    start = rng.randrange(len(text) + 1)
    end = min(len(text), start + rng.choice((0, 0, 1, 1, 5, 80)))
    piece = rng.choice((rng.choice(PIECES), "", text[end : end + rng.randrange(60)]))
    return (text[:start] + piece + text[end:])[:6000]


def type_and_ask(edits: int, seed: int) -> None:
    rng, buffers = random.Random(seed), Buffers(ROOT)
    for number in range(edits):
        if number % 20 == 0:
            source = rng.choice(PROGRAMS)
            path, text = Path("/nowhere") / source.name, source.read_text("utf-8")
        text = edited(text, rng)
        buffers.change(path, text)
        lines = text.splitlines()
        fixed(text, buffers.diagnostics(path))
        line = rng.randrange(len(lines) + 1)
        at = cursor(lines, line, rng.randrange(80))
        choices(buffers, path, at.steps)
        keys(text, at.steps)
        hover(buffers, path, at)
        definition(buffers, path, at)
        list(colored_words(buffers, path))
        with suppress(DiagnosticsError):
            formatted_text(text, "a.yaml")
        if number % 20 == 10:
            renaming(buffers, path, at)


def test_few_hundred_edits() -> None:
    type_and_ask(300, seed=1)


@pytest.mark.slow
def test_few_thousand_edits() -> None:
    type_and_ask(2_500, seed=2)
