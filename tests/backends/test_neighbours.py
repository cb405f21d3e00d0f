"""Neighbours of an object in the world: its contacts, on every engine with contact forces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import BACKENDS, embody
from cbdsl.documents.robot import RobotDocument
from tests.backends.conftest import sightless, stage_named


@pytest.mark.parametrize("name", ["bullet", "mujoco"])
def test_neighbours_of_an_object_are_its_contacts(
    name: str, dexter: RobotDocument, urdf: Path
) -> None:
    if name not in BACKENDS.usable_names():
        pytest.skip(f"{name} is not installed")
    backend = embody(name, sightless(dexter), urdf)
    backend.reset(stage_named("stacked"), None, np.random.default_rng(1))
    for _ in range(60):
        backend.apply(backend.observe().positions)
        backend.step()
    truth = backend.truth  # type: ignore[attr-defined]
    fixtures = stage_named("stacked").fixtures
    things = [each for each in truth.names() if each not in fixtures]
    found = {each: truth.neighbours(each) for each in things}
    backend.close()
    assert any(near == {"table"} or "table" in near for near in found.values())
    for thing, near in found.items():
        assert near and thing not in near
        assert all(thing in found[other] for other in near if other in found)
