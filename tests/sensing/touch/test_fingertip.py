"""Contact places on round fingertips, from force and torque alone."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.sensing.touch.fingertip import add_contact

RADIUS = 0.012


@pytest.mark.parametrize("seed", range(8))
def test_add_contact_of_a_force_at_the_surface_returns_its_place(seed: int) -> None:
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    # The force points outwards, within a friction cone about the normal.
    force = 3.0 * normal + np.cross(normal, rng.uniform(-1.0, 1.0, 3))
    load = np.concatenate([force, np.cross(RADIUS * normal, force)])
    middle = rng.normal(size=3)
    place = middle.copy()
    add_contact(load, RADIUS, place)
    assert place == pytest.approx(middle + RADIUS * normal, abs=1e-12)


@pytest.mark.parametrize(
    "load",
    [np.zeros(6), np.array([1.0, 0.0, 0.0, 0.0, 0.0, 1.0])],
    ids=["no force", "large torque"],
)
def test_add_contact_never_leaves_the_fingertip(load: np.ndarray) -> None:
    place = np.zeros(3)
    add_contact(load, RADIUS, place)
    assert np.linalg.norm(place) <= RADIUS + 1e-12


def test_add_contact_without_a_radius_stays_in_the_middle() -> None:
    place = np.ones(3)
    add_contact(np.array([1.0, 2.0, 3.0, 0.1, 0.0, -0.1]), 0.0, place)
    assert place == pytest.approx(np.ones(3))
