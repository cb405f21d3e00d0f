"""Attention: selected instances, and the object attended to while objects come and go."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cbdsl.documents.robot import Regions
from cbdsl.sensing.vision.memory.attention import Attention
from cbdsl.sensing.vision.memory.object_memories import ObjectMemories

#: Cameras in the middle look along x; y is to the left.
FIELD: Any = SimpleNamespace(middle=np.zeros(3))
PLACES = ((0.9, 0.3, 0.0), (0.5, -0.2, 0.0), (0.7, 0.0, 0.0))
SIZES = (0.02, 0.03, 0.04)


@pytest.fixture
def objects() -> ObjectMemories:
    """Return three remembered objects."""
    objects = ObjectMemories(Regions(instances=3), 2)
    for memory, place, radius in zip(objects.memories, PLACES, SIZES, strict=True):
        area = np.pi * radius**2
        memory.see(0.0, np.array(place), (area, area))
    return objects


@pytest.mark.parametrize(
    ("instance", "number"),
    [
        ("", 0),
        ("2", 1),
        ("nearest", 1),
        ("largest", 2),
        ("leftmost", 0),
        ("rightmost", 1),
        ("other", 2),
    ],
)
def test_number_of_an_instance_follows_its_selection(
    objects: ObjectMemories, instance: str, number: int
) -> None:
    assert objects.known == [0, 1, 2] and objects.free is None
    assert Attention(objects, FIELD).number(instance) == number


def test_number_without_objects_is_none_for_a_selection() -> None:
    objects = ObjectMemories(Regions(instances=2), 2)
    attention = Attention(objects, FIELD)
    assert attention.number("nearest") is None and attention.number("") == 0


def test_attention_moves_to_the_object_nearest_to_the_forgotten_one(
    objects: ObjectMemories,
) -> None:
    attention = Attention(objects, FIELD)
    attention.update()
    objects.memories[1].reset()
    attention.update()
    assert attention.attended == 0
    objects.memories[0].reset()
    attention.update()
    assert attention.attended == 2 and objects.free == 0


def test_objects_of_one_camera_have_no_memories() -> None:
    objects = ObjectMemories(Regions(instances=3), 1)
    attention = Attention(objects, FIELD)
    attention.update()
    assert objects.memories == () and attention.attended == 0 and len(objects.sightings) == 1
