"""Stage documents: patterns on the sides of objects, and meshes."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from cbdsl.documents.document_digest import digest
from cbdsl.documents.form import BallForm, BoxForm, CylinderForm, MeshForm
from cbdsl.documents.stage import StageDocument
from cbdsl.yaml_text.library import Library


def _box(**pattern: Any) -> BoxForm:
    form = {"shape": "box", "size": ["10 cm", ["20 cm", "30 cm"], "15 cm"]}
    return BoxForm.model_validate({**form, "pattern": {"height": "15 cm", **pattern}})


def test_pattern_has_room_on_the_smallest_box_that_can_be_drawn() -> None:
    assert _box(face="-x", stripes=["1 cm"] * 19).pattern is not None
    with pytest.raises(ValidationError, match="larger than the side"):
        _box(face="-x", stripes=["1 cm"] * 21)


@pytest.mark.parametrize("face", ["-y", "+y"])
def test_sides_are_as_wide_as_the_box_is_deep(face: str) -> None:
    assert _box(face=face, stripes=["1 cm"] * 9).pattern is not None
    with pytest.raises(ValidationError, match="larger than the side"):
        _box(face=face, stripes=["1 cm"] * 11)


def test_pattern_is_no_higher_than_the_box() -> None:
    with pytest.raises(ValidationError, match="larger than the side"):
        _box(stripes=["1 cm"], height="16 cm")


@pytest.mark.parametrize("stripes", [[], ["0 cm"], ["-1 cm"], ["10 deg"], ["1 cm", "1 cm"]])
def test_stripes_have_widths_and_end_with_a_bar(stripes: list[str]) -> None:
    with pytest.raises(ValidationError):
        _box(stripes=stripes)


@pytest.mark.parametrize(("radius", "fits"), [("5 cm", True), ("5.1 cm", False)])
@pytest.mark.parametrize("face", ["-x", "+y"])
def test_spot_has_room_on_the_smallest_thing_that_can_be_drawn(
    radius: str, fits: bool, face: str
) -> None:
    spot = {"face": face, "radius": radius, "color": [0, 0, 1]}
    box = {"shape": "box", "size": ["10 cm", ["10 cm", "30 cm"], "15 cm"], "spot": spot}
    ball = {"shape": "ball", "radius": ["5.05 cm", "7 cm"], "spot": spot}
    wide = {"shape": "cylinder", "radius": ["5.05 cm", "9 cm"], "height": "20 cm", "spot": spot}
    low = {"shape": "cylinder", "radius": "9 cm", "height": ["10.1 cm", "20 cm"], "spot": spot}
    for form, made in (
        (box, BoxForm),
        (ball, BallForm),
        (wide, CylinderForm),
        (low, CylinderForm),
    ):
        if fits:
            assert made.model_validate(form).spot is not None
        else:
            with pytest.raises(ValidationError, match="the spot is larger than the side"):
                made.model_validate(form)


def test_digest_of_a_stage_changes_with_its_mesh(tmp_path: Path) -> None:
    text = (
        "cbdsl: 1\nkind: stage\nname: made\nrobot: dexter\nthings:\n"
        "  wedge: {form: {shape: mesh, file: wedge.obj}, mass: 100 g}\n"
        "contexts:\n  all: {things: [wedge], place: {z: 0}}\n"
    )

    def identity(folder: str, mesh: str) -> tuple[StageDocument, str]:
        place = tmp_path / folder
        place.mkdir(exist_ok=True)
        (place / "made.yaml").write_text(text)
        (place / "wedge.obj").write_text(mesh)
        document = Library(place).read(place / "made.yaml", StageDocument).document
        return document, digest(document)

    (here, before), (there, same), (_, other) = (
        identity("here", "v 0 0 0"), identity("there", "v 0 0 0"), identity("new", "v 0 0 1")
    )  # fmt: skip
    assert here == there and before == same
    assert before != other
    form = here.things["wedge"].form
    assert isinstance(form, MeshForm) and form.path == tmp_path / "here" / "wedge.obj"
    assert pickle.loads(pickle.dumps(form)).path == form.path
