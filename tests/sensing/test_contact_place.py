"""Where a round fingertip is touched, by force and torque."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.sensing.contact_place import on_ball

RADIUS = 0.012


@pytest.mark.parametrize("seed", range(5))
def test_a_contact_with_friction_is_found_where_it_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    place = RADIUS * normal
    # Within the cone of friction, so that the force alone would point elsewhere.
    force = 2.0 * normal + 0.5 * np.cross(normal, rng.normal(size=3))
    load = np.concatenate([force, np.cross(place, force)])
    assert on_ball(load, RADIUS) == pytest.approx(place, abs=1e-9)
    assert np.linalg.norm(RADIUS * force / np.linalg.norm(force) - place) > 1e-4


def test_a_torque_that_no_contact_causes_keeps_the_place_on_the_ball() -> None:
    load = np.array([0.0, 0.0, -1.0, 0.1, 0.0, 0.0])
    assert np.linalg.norm(on_ball(load, RADIUS)) == pytest.approx(RADIUS)
