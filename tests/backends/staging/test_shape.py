"""Shapes are drawn within their forms' spans, and know how far down they reach."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import TypeAdapter

from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.form import BallForm, BoxForm, CylinderForm
from cbdsl.kinematics.pose import Pose

FORMS = {
    "ball": {"shape": "ball", "radius": [0.04, 0.06]},
    "box": {"shape": "box", "size": [0.1, 0.2, [0.06, 0.1]]},
    "cylinder": {"shape": "cylinder", "radius": 0.05, "height": [0.08, 0.12]},
}
HALVES = {
    "ball": [(0.04, 0.06)] * 3,
    "box": [(0.05, 0.05), (0.1, 0.1), (0.03, 0.05)],
    "cylinder": [(0.05, 0.05), (0.05, 0.05), (0.04, 0.06)],
}


@pytest.mark.parametrize("kind", FORMS)
def test_shape_is_drawn_within_its_form(kind: str) -> None:
    form: BallForm | BoxForm | CylinderForm = TypeAdapter(
        BallForm | BoxForm | CylinderForm
    ).validate_python(FORMS[kind])
    rng = np.random.default_rng(0)
    shapes = [SolidShape.draw(form, rng) for _ in range(20)]
    assert {shape.kind for shape in shapes} == {kind}
    assert len({shape.half_height for shape in shapes}) == 20
    for shape in shapes:
        for half, (least, most) in zip(shape.halves, HALVES[kind], strict=True):
            assert least - 1e-12 <= half <= most + 1e-12


@pytest.mark.parametrize(
    "shape",
    [SolidShape.ball(0.05), SolidShape("box", (0.03, 0.05, 0.08)), SolidShape.cylinder(0.04, 0.1)],
)
def test_no_point_of_a_shape_exceeds_its_depth(shape: SolidShape) -> None:
    rng = np.random.default_rng(0)
    directions = rng.standard_normal((20000, 3))
    for _ in range(5):
        axis = rng.standard_normal(3)
        rotation = Pose.turned(axis / np.linalg.norm(axis), rng.uniform(-3, 3)).rotation
        lowest = (_surface(shape, directions) @ rotation.T)[:, 2].min()
        assert -shape.depth(rotation) == pytest.approx(lowest, abs=2e-3)
        assert -shape.depth(rotation) <= lowest + 1e-12
    assert shape.depth(np.eye(3)) == pytest.approx(shape.half_height)


def _surface(shape: SolidShape, directions: np.ndarray) -> np.ndarray:
    """Return the points where rays from the centre leave a shape, shape (n, 3)."""
    if shape.kind == "ball":
        sizes = np.linalg.norm(directions, axis=1) / shape.halves[0]
    elif shape.kind == "box":
        sizes = np.abs(directions / shape.halves).max(axis=1)
    else:
        around = np.linalg.norm(directions[:, :2], axis=1) / shape.halves[0]
        sizes = np.maximum(around, np.abs(directions[:, 2]) / shape.halves[2])
    return directions / sizes[:, None]
