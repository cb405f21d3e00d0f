"""Literals of orientations: rotation vectors and quaternions are two ways to write one rotation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cbdsl.checking.controller.references import LiteralError, read_literal
from cbdsl.kinematics.rotation import exp
from cbdsl.program.controller import Literal
from cbdsl.types.resource import Origin, Resource, Tip
from cbdsl.types.resource_type import ORIENTATION, POSE

TURNED = Resource("arm.orientation", ORIENTATION, Origin.KINEMATICS, Tip("arm", "orientation"))
PLACED = Resource("arm.pose", POSE, Origin.KINEMATICS, Tip("arm", "pose"))


@pytest.mark.parametrize("sign", [1, -1])
def test_literal_quaternion_equals_the_rotation_of_scipy(sign: int) -> None:
    for rotation in Rotation.random(20, random_state=3):
        items = tuple(sign * float(each) for each in rotation.as_quat())
        literal = read_literal(items, TURNED)
        assert isinstance(literal, Literal)
        np.testing.assert_allclose(exp(np.array(literal.values)), rotation.as_matrix(), atol=1e-12)


def test_identity_quaternion_is_accepted() -> None:
    assert read_literal((0, 0, 0, 1), TURNED) == Literal((0.0, 0.0, 0.0))


def test_pose_has_its_quaternion_behind_the_position() -> None:
    literal = read_literal(("10 cm", 0, "2 m", 0, 0, 0.7071, 0.7071), PLACED)
    assert isinstance(literal, Literal)
    np.testing.assert_allclose(literal.values, [0.1, 0, 2, 0, 0, np.pi / 2], atol=1e-4)


@pytest.mark.parametrize(
    ("items", "code"),
    [((1, 0, 0, 1), "CB593"), ((0, 0, 0, 0), "CB593"), (("1 rad", 0, 0, 0), "CB506")],
)
def test_literal_quaternion_of_another_norm_is_refused(
    items: tuple[str | float, ...], code: str
) -> None:
    with pytest.raises(LiteralError) as caught:
        read_literal(items, TURNED)
    assert caught.value.code == code
