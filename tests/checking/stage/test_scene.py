"""Scenes that certainly overlap, which are found, and all others, which are not."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.yaml_text.library import Library

HEAD = """cbdsl: 1
kind: stage
name: scene
robot: dexter
fixtures:
  table: {form: {shape: box, size: [60 cm, 120 cm, 4 cm]}, position: [60 cm, 0 cm, -44 cm]}
  wall: {form: {shape: box, size: [4 cm, 40 cm, 40 cm]}, position: [70 cm, 0 cm, -22 cm]}
things:
  ball: {form: {shape: ball, radius: [4 cm, 6 cm]}, mass: 200 g}
  box: {form: {shape: box, size: [10 cm, 20 cm, 8 cm]}, mass: 300 g}
  tube: {form: {shape: tube, radius: 8 cm, height: 8 cm, wall: 1 cm}, mass: 300 g}
contexts:
  only:
    placed:
"""


def codes(folder: Path, text: str) -> list[str]:
    path = folder / "programs" / "stages" / "scene.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    found = check_document(path, session=Session(Library(folder)))
    return [diagnostic.code for diagnostic in found if diagnostic.code != "CB715"]


def placed(**places: str) -> str:
    rows = (f"      {name}: {place}\n" for name, place in places.items())
    return HEAD + "".join(rows)


@pytest.mark.parametrize(
    ("one", "other", "overlap"),
    [
        ("{things: [ball], place: {on: table, x: 45 cm}}", "x: 51 cm", True),
        ("{things: [ball], place: {on: table, x: 45 cm}}", "x: 54 cm", False),
        ("{things: [ball], place: {on: table, x: [45 cm, 50 cm]}}", "x: 48 cm", False),
        ("{things: [box], place: {on: table, x: 45 cm}}", "x: 45 cm, y: 13 cm", True),
        ("{things: [box], place: {on: table, x: 45 cm}}", "x: 45 cm, y: 15 cm", False),
        # A box with a random yaw fills at least the cylinder inscribed in it.
        (
            "{things: [box], place: {on: table, x: 45 cm, yaw: [-90 deg, 90 deg]}}",
            "x: 45 cm, y: 8 cm",
            True,
        ),
        (
            "{things: [box], place: {on: table, x: 45 cm, yaw: [-90 deg, 90 deg]}}",
            "x: 45 cm, y: 10 cm",
            False,
        ),
        ("{things: [box], place: {on: table, x: 45 cm, yaw: 90 deg}}", "x: 45 cm, y: 10 cm", False),
        # An object inside a hollow one does not overlap it.
        ("{things: [tube], place: {on: table, x: 45 cm}}", "x: 45 cm", False),
    ],
)
def test_things_overlap_for_certain_or_not(
    tmp_path: Path, one: str, other: str, overlap: bool
) -> None:
    text = placed(one=one, other=f"{{things: [ball], place: {{on: table, {other}}}}}")
    assert codes(tmp_path, text) == (["CB362"] if overlap else [])


def test_object_inside_a_wall_is_reported_for_every_kind_of_place(tmp_path: Path) -> None:
    on = "{things: [ball], place: {on: table, x: 70 cm}}"
    assert codes(tmp_path, placed(ball=on)) == ["CB362"]
    beside = {
        "one": "{things: [ball], place: {on: table, x: 45 cm}}",
        "two": "{things: [ball], place: {beside: {name: one, by: 25 cm, direction: 0}}}",
    }
    assert codes(tmp_path, placed(**beside)) == ["CB362"]
    stacked = {
        "one": "{things: [box], place: {on: table, x: 45 cm}}",
        "two": "{things: [ball], place: {on: one}}",
    }
    assert codes(tmp_path, placed(**stacked)) == []


def test_unknown_neighbour_is_reported_with_the_known_ones(tmp_path: Path) -> None:
    text = placed(
        one="{things: [ball], place: {on: tabel, x: 45 cm}}",
        two="{things: [ball], place: {beside: {name: tow, by: 25 cm}}}",
    )
    assert codes(tmp_path, text) == ["CB351", "CB351"]


def test_placed_thing_has_a_name_of_its_own(tmp_path: Path) -> None:
    text = placed(table="{things: [ball], place: {x: 45 cm, z: 0}}")
    assert codes(tmp_path, text) == ["CB354"]


@pytest.mark.parametrize(
    ("position", "inside"),
    [
        ("[-12 cm, 0, 0]", True),
        ("[[-13 cm, -11 cm], 0, 0]", False),
        ("[-12 cm, 0, -1]", False),
        ("[0, 0, 0]", False),
    ],
)
def test_fixture_certainly_inside_the_robot_is_reported(
    tmp_path: Path, position: str, inside: bool
) -> None:
    pole = "  pole: {form: {shape: cylinder, radius: 5 cm, height: 40 cm}, position: %s}\n"
    text = placed(ball="{things: [ball], place: {on: table, x: 45 cm}}")
    text = text.replace("things:\n  ball", pole % position + "things:\n  ball")
    assert codes(tmp_path, text) == (["CB363"] if inside else [])
