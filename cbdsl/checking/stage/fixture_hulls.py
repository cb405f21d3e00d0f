"""Hulls around the fixtures of a stage from which links keep a distance."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

from cbdsl.documents.form import BallForm, BoxForm, CylinderForm, OpenBoxForm, TubeForm
from cbdsl.documents.robot import HullSection
from cbdsl.documents.stage import Fixture, StageDocument

# Number of corners around a cylinder, of which each side touches it.
_SIDES = 12

_Corner = tuple[float, float, float]


def fixture_hull(name: str, stage: StageDocument) -> HullSection | str:
    """Return a hull around a fixture in the world frame, or a clause about the lack of one.

    A fixture in a random place is covered in all its places.

    Args:
        name: Name of the fixture.
        stage: Stage.
    """
    fixture = stage.fixtures.get(name)
    if fixture is None:
        known = ", ".join(stage.fixtures) or "none"
        return f"'{name}' is no fixture of stage '{stage.name}' (known: {known})"
    corners = list(_corners(fixture))
    if not corners:
        return f"fixture '{name}' is of shape '{fixture.form.shape}', around which no hull is known"
    points = {
        (at[0] + corner[0], at[1] + corner[1], at[2] + corner[2])
        for at in product(*fixture.position)
        for corner in corners
    }
    radius = fixture.form.radius[1] if isinstance(fixture.form, BallForm) else 0.0
    return HullSection(points=tuple(sorted(points)), radius=radius)


def _corners(fixture: Fixture) -> Iterator[_Corner]:
    """Yield the corners of a form about its centre, m; none of a form without a simple hull."""
    form = fixture.form
    if isinstance(form, BallForm):
        yield 0.0, 0.0, 0.0
    elif isinstance(form, BoxForm | OpenBoxForm):
        x, y, z = (0.5 * side[1] for side in form.size)
        yield from product((-x, x), (-y, y), (-z, z))
    elif isinstance(form, CylinderForm | TubeForm):
        reach, half = form.radius[1] / math.cos(math.pi / _SIDES), 0.5 * form.height[1]
        for side, end in product(range(_SIDES), (-half, half)):
            turn = 2.0 * math.pi * side / _SIDES
            yield reach * math.cos(turn), reach * math.sin(turn), end
