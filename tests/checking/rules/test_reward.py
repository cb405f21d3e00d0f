"""Programs without learnable reward, which are reported before learning begins."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.program import check_program
from cbdsl.checking.rules.reward import check_rewarded
from cbdsl.documents.program import ProgramDocument
from cbdsl.yaml_text.library import Library

HEAD = "cbdsl: 1\nkind: program\nname: own\nrobot: dexter\n"
STAY = "{potential: spring, reference: head.ahead, feedback: head, effector: head}"
TRACK = "{potential: spring, reference: 0, feedback: cyclopean.motion, effector: head}"


def told(path: Path, library: Library) -> list[str]:
    program = check_program(path, library=library)
    return [found.message for found in check_rewarded(program, path, library)]


@pytest.mark.parametrize("name", ["searchtrack", "tactileprobe", "reachtouch", "visualinspect"])
def test_shipped_learned_program_has_a_possible_reward(name: str) -> None:
    library = Library()
    assert told(library.locate(ProgramDocument, name), library) == []


@pytest.mark.parametrize("name", ["posture", "poise"])
def test_program_of_motions_alone_has_no_reward(name: str) -> None:
    library = Library()
    (message,) = told(library.locate(ProgramDocument, name), library)
    assert "measures a heading or a force" in message


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (
            f"controllers:\n  stay: {STAY}\n  track: {TRACK}\n  both: stay ◁ track\n"
            "actions: [both]\n",
            "'track', which could be, is not an action by itself",
        ),
        (
            f"use: {{look: {{program: searchtrack}}}}\ncontrollers: {{stay: {STAY}}}\n"
            "actions: [look, stay]\n",
            "what 'look' earns is its own",
        ),
    ],
    ids=["composed", "used"],
)
def test_reward_that_is_not_the_programs_own_is_named(text: str, why: str, tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text(HEAD + text, encoding="utf-8")
    (message,) = told(path, Library(tmp_path))
    assert why in message


LOCALIZE = "{potential: localizability, feedback: cameras.red, effector: right_arm.position}"


def test_conditioning_earns_nothing_for_any_signal(tmp_path: Path) -> None:
    """Controllers without a reference do not track the environment (Section 4.2)."""
    path = tmp_path / "own.yaml"
    text = f"controllers: {{look: {LOCALIZE}, track: {TRACK}}}\nactions: [look, track]\n"
    path.write_text(HEAD + text, encoding="utf-8")
    program = check_program(path, library=Library(tmp_path))
    rewarded = {each.name: each.rewarded for each in program.primitives.values()}
    assert rewarded == {"look": False, "track": True}
