"""Cursor positions in block and flow style, in unfinished texts."""

from __future__ import annotations

import pytest

from cbdsl.editor.cursor import cursor

TEXT = """\
kind: program
robot: dexter
controllers:
  track: {potential: spring, reference: [0 deg, 0 deg], feedback: cyclopean.re, effector: }
  touch:
    potential: spring
    seek: {once: approach, within: 2 cm}
    fee
actions: [search, tra]
policy:
  "**": search ◁ tr
"""


@pytest.mark.parametrize(
    ("mark", "steps", "word", "on_key"),
    [
        ("robot: dex", ("robot",), "dexter", False),
        ("cyclopean.re", ("controllers", "track", "feedback"), "cyclopean.re", False),
        ("effector: ", ("controllers", "track", "effector"), "", False),
        ("[0 deg, 0 d", ("controllers", "track", "reference"), "deg", False),
        ("once: appr", ("controllers", "touch", "seek", "once"), "approach", False),
        ("{once: approach, with", ("controllers", "touch", "seek"), "within", True),
        ("    fee", ("controllers", "touch"), "fee", True),
        ("actions: [search, tra", ("actions",), "tra", False),
        ("search ◁ tr", ("policy", "**"), "tr", False),
        ("  tou", ("controllers",), "touch", True),
    ],
)
def test_cursor_returns_the_word_and_its_section(
    mark: str, steps: tuple[str, ...], word: str, on_key: bool
) -> None:
    before = TEXT[: TEXT.index(mark) + len(mark)]
    line, column = before.count("\n"), len(before) - before.rfind("\n") - 1
    at = cursor(TEXT.splitlines(), line, column)
    assert (at.steps, at.word, at.on_key) == (steps, word, on_key)


def test_cursor_beyond_the_text_has_no_word() -> None:
    assert cursor([], 7, 3).word == ""
