"""Shapes of documents at a path, derived from their models."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from pydantic import BaseModel

from cbdsl.documents.form import (
    BallForm,
    BoxForm,
    ComposedForm,
    CylinderForm,
    MeshForm,
    OpenBoxForm,
    TubeForm,
)
from cbdsl.documents.kinds import KINDS as ALL
from cbdsl.documents.kinds import models
from cbdsl.documents.program import ControllerSection, ProgramDocument
from cbdsl.documents.stage import StageDocument, ThingSection
from cbdsl.yaml_text.repair.schema_shape import SchemaShape

#: Models of all kinds but those of other packages.
KINDS = {name: model for name, model in models().items() if ALL.is_builtin(name)}


def _sections(
    model: type[BaseModel], above: tuple[type[BaseModel], ...] = ()
) -> Iterator[type[BaseModel]]:
    """Yield a document's model and all sections below it, ending where a section recurs."""
    if model in above:
        return
    yield model
    for key in SchemaShape((model,)).keys:
        shape = SchemaShape((model,)).child(key)
        for part in (shape, shape.child(""), shape.child(0)):
            for section in part.sections:
                yield from _sections(section, (*above, model))


@pytest.mark.parametrize("kind", KINDS)
def test_required_keys_of_a_shape_complete_a_section(kind: str) -> None:
    for section in _sections(KINDS[kind]):
        shape = SchemaShape((section,))
        required = {key for key, field in shape.keys.items() if field.is_required()}
        assert shape.is_complete(required)
        assert not any(shape.is_complete(required - {key}) for key in required)


@pytest.mark.parametrize(
    ("model", "steps", "kinds"),
    [
        (StageDocument, ("things", "cup"), (ThingSection,)),
        (
            StageDocument,
            ("things", "cup", "form"),
            (BallForm, BoxForm, CylinderForm, TubeForm, OpenBoxForm, ComposedForm, MeshForm),
        ),
        (StageDocument, ("things", "cup", "unknown"), ()),
        (StageDocument, ("things", 0), ()),
        (ProgramDocument, ("controllers", "reach"), (ControllerSection, str)),
        (ProgramDocument, ("use", "x", "with", "gain"), (str,)),
        (ProgramDocument, ("actions", 3), (str,)),
        (ProgramDocument, ("actions", "reach"), ()),
    ],
)
def test_shape_at_a_path_is_that_of_its_section(
    model: type[BaseModel], steps: tuple[Any, ...], kinds: tuple[type, ...]
) -> None:
    assert SchemaShape((model,)).at(steps).kinds == kinds


@pytest.mark.parametrize(
    ("loc", "sections"),
    [
        (("things", "cup", "form", "ball"), (BallForm,)),
        (("things", "form"), (ThingSection,)),
        (("things", "ball", "form", "box"), (BoxForm,)),
    ],
)
def test_tags_choose_of_a_union_and_names_are_no_keys(
    loc: tuple[str, ...], sections: tuple[type, ...]
) -> None:
    assert SchemaShape((StageDocument,)).located(loc).sections == sections


def test_names_of_types_in_a_location_are_passed_over() -> None:
    shape = SchemaShape((ProgramDocument,)).located(("controllers", "reach", "Controller"))
    assert shape.sections == (ControllerSection,)
