"""Cached controllers of an editor's session: the same diagnostics without repeated checks."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from cbdsl.checking.controller.triple import check_triple
from cbdsl.checking.rules import compositions
from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.editor.buffers import Buffers
from tests.conftest import ROOT
from tests.editor.test_random_edits import PROGRAMS, edited

#: Replaced texts of valid programs, with their replacements.
WORDS = {
    "spring": ("springs", "manipulability", "spring"),
    "right_arm": ("left_arm", "right_hand", "$arm"),
    "8 /s": ("8 m", "0 /s", "9 /s"),
    "robot: dexter": ("robot: panda", "robot: dextre", "robot: dexter "),
    # Names that other sections of the program use for a controller.
    "  hold: ": ("  holds: ", "  hold : "),
    "models: {": ("models: {other_", "modelled: {"),
    "searchtrack: {program": ("seeks: {program", "searchtrack: {programs"),
    "controllers:": ("controllers: {}", "controls:", "controllers:\n  more: {potential: spring}"),
}


def fresh_diagnostics(path: Path, text: str) -> list[Diagnostic]:
    """Return the diagnostics of a text in a session that has checked nothing before."""
    fresh = Buffers(ROOT)
    fresh.change(path, text)
    return fresh.diagnostics(path)


#: Programs whose edits are checked with the fast tests; all others take minutes together.
SMALL = ("posture", "reach", "searchtrack", "twist")


@pytest.mark.parametrize(
    "program",
    [pytest.param(each, marks=() if each.stem in SMALL else pytest.mark.slow) for each in PROGRAMS],
    ids=lambda path: path.stem,
)
def test_diagnostics_after_edits_equal_a_fresh_session(program: Path) -> None:
    """Diagnostics agree after each of many changes, valid or not, and after each reversal."""
    path, text, kept = ROOT / "programs" / program.name, program.read_text("utf-8"), Buffers(ROOT)
    rng = random.Random(program.stem)
    changed = [text.replace(old, new) for old, news in WORDS.items() for new in news]
    changed += [edited(text, rng) for _ in range(6)]
    unchanged = fresh_diagnostics(path, text)
    # Most programs lack some of the words, which leaves their text as it was.
    for each in dict.fromkeys(changed):
        kept.change(path, text)
        assert kept.diagnostics(path) == unchanged
        kept.change(path, each)
        assert kept.diagnostics(path) == fresh_diagnostics(path, each)


def test_only_the_controller_that_changed_is_checked_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    program = ROOT / "programs" / "bimanualtouch.yaml"
    text, buffers, checked = program.read_text("utf-8"), Buffers(ROOT), list[str]()

    def counted(context, key, *rest):  # type: ignore[no-untyped-def]
        checked.append(key)
        return check_triple(context, key, *rest)

    monkeypatch.setattr(compositions, "check_triple", counted)
    plain = "  plain: {potential: spring, reference: head.uniform, feedback: head, effector: head"
    for gain, again in (("8 /s", True), ("8 /s", False), ("9 /s", True)):
        typed = text.replace("controllers:\n", f"controllers:\n{plain}, gain: {gain}}}\n")
        assert typed != text
        checked.clear()
        buffers.change(program, f"{typed}# {again}\n")
        buffers.diagnostics(program)
        assert ("plain" in checked) is again
