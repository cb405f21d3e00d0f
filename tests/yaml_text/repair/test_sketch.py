"""Proposed forms of values: they have the shape that the document requires."""

from __future__ import annotations

import pytest

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.repair.sketch import form


@pytest.mark.parametrize(
    ("model", "steps", "wanted"),
    [
        (RobotDocument, ("effectors", "arm", "tip"), "{link: ...}"),
        (RobotDocument, ("effectors",), "{NAME: {joints: [...]}}"),
        (RobotDocument, ("couplings",), "{KEY: {follows: ..., ratio: ...}}"),
        (RobotDocument, ("simulation", "no_contact"), "[[...], ...]"),
        (RobotDocument, ("effectors", "arm", "tip", "offset"), "[..., ..., ...]"),
        (RobotDocument, ("base",), None),
        (ProgramDocument, ("limits",), "{transitions: ..., transition_time: ..., idle_time: ...}"),
        (ProgramDocument, ("use",), "{NAME: {program: ...}}"),
        (StageDocument, ("contexts", "one", "nowhere"), None),
    ],
)
def test_forms_have_the_keys_that_are_required(
    model: type, steps: tuple[str, ...], wanted: str | None
) -> None:
    assert form(model, steps) == wanted


def test_form_puts_the_written_value_under_its_key() -> None:
    place = Place("here")
    link = Node(place, "palm")
    assert form(RobotDocument, ("effectors", "arm", "tip"), link) == "{link: palm}"
    assert form(RobotDocument, ("groups", "arms"), Node(place, [link])) == "{members: [palm]}"
    assert form(RobotDocument, ("effectors", "arm", "joints"), link) == "[palm]"
