"""Benches: a table within a robot's reach, and the ball of a proposed stage on it."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import NamedTuple

from cbdsl.documents.robot import Effector, RobotDocument
from cbdsl.robot.link_place import PLACING, at_first, link_frame, within
from cbdsl.robot.urdf import UrdfError, UrdfModel, Vector
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.types.unit import read_quantity


class Bench(NamedTuple):
    """Table in front of a robot, and the region of objects on it.

    Attributes:
        size: Edge lengths of the table top, m.
        position: Position of the centre of the table top, m.
        x, y: Minimum and maximum coordinates of objects, m.
        radius: Minimum and maximum radius of a ball, m.
        reach: Length of the limb before which it stands, m.
    """

    size: Vector
    position: Vector
    x: tuple[float, float]
    y: tuple[float, float]
    radius: tuple[float, float]
    reach: float

    def values(self) -> dict[str, str]:
        """Return the values of the stage template's placeholders, in centimetres."""
        spans = {name: each for name, each in self._asdict().items() if isinstance(each, tuple)}
        return {name: f"[{', '.join(map(_centimetres, each))}]" for name, each in spans.items()}


# Bench for a robot without recognizable limbs, m.
_ANY = Bench((0.6, 1.2, 0.04), (0.6, 0.0, -0.44), (0.4, 0.8), (-0.4, 0.4), (0.03, 0.05), 1.0)
# Fractions of a limb's length: least and greatest distance of the table's centre; depth, width and
# thickness of the table; greatest offset of objects from its centre; minimum radius of a ball;
# distance of the table below a tip that hangs down.
_AWAY, _DEEP, _WIDE, _THICK, _AROUND, _BALL, _BELOW = (0.45, 0.6), 0.4, 0.8, 0.03, 0.12, 0.03, 0.1
# Fractions of a limb's length. A limb whose shoulder and tip are this far above the robot's base
# works on the surface on which the robot stands.
_BASE, _STANDING = 0.02, 0.1
# Greatest height of a shoulder above the table, in lengths of the limb.
_DEEPEST = 0.45


# Model of a bench: all measures are fractions of the limb's length, so that proposals suit robots
# of any size. The table is in the direction from the shoulder to the tip, at 0.45 to 0.6 lengths.
# It is parallel to the axes, because stages place objects within ranges of x and y. Its top is
# below the lowest named posture of the tip. If the limb is above the robot's base, the top is at
# height 0, the surface on which the robot stands, or not far below the shoulder. The assumption is
# that objects near the tip's own distance can be reached. No inverse kinematics is solved: joint
# limits may exclude a part of the table.
def bench(robot: RobotDocument, file: Path) -> Bench:
    """Return a bench in front of the longest limbs of a robot, below their tips.

    The bench of a single limb is on the side of its tip; the bench of several limbs is ahead.

    Args:
        robot: Robot of the stage.
        file: Document of the robot.
    """
    try:
        model = read_urdf(file.parent / robot.model)
    except UrdfError:
        return _ANY  # the model has its own diagnostics
    limbs = [each for each in robot.effectors.values() if _is_limb(model, each)]
    most = max((len(each.joints) for each in limbs), default=0)
    return _before([_Limb(model, each) for each in limbs if len(each.joints) == most])


def measures_of(robot: RobotDocument, file: Path, parts: Collection[str]) -> dict[str, float]:
    """Return the reach, the middle of the bench's top, and a span of a robot, by name, m.

    The value ``table`` of an arm is the height of its bench.

    Args:
        robot: Robot.
        file: Document of the robot.
        parts: Effectors that act, whose values count; those of the first ones if empty.

    Raises:
        QuantityError: The span or the height is no length.
    """
    names = [name for name in (*parts, *robot.effectors) if name in robot.effectors]
    stated = {k: v for name in names[::-1] for k, v in robot.effectors[name].values.items()}
    known = {"span": "span", "table": "bench.z"}
    own = {known[k]: read_quantity(v, ("length",)) for k, v in stated.items() if k in known}
    table = bench(robot, file)
    x, y, z = table.position
    top = z + table.size[2] / 2
    return {"reach": table.reach, "bench.x": x, "bench.y": y, "bench.z": top, **own}


def _is_limb(model: UrdfModel, limb: Effector) -> bool:
    """Return whether an effector can be positioned, and a model has its joints and its tip."""
    return (
        len(limb.joints) >= PLACING
        and limb.tip is not None
        and limb.tip.link in model.links
        and {*limb.joints} <= {*model.joints}
    )


class _Limb:
    """Limb at the start of episodes: its length, shoulder, tip and lowest posture, m."""

    def __init__(self, model: UrdfModel, limb: Effector) -> None:
        assert limb.tip is not None
        self._model, self._limb, self._end = model, limb, limb.tip
        way = model.way(limb.tip.link)[::-1]
        self._positions = {joint.name: at_first(joint) for joint in way if joint.movable}
        first = next(i for i, joint in enumerate(way) if joint.name in limb.joints)
        beyond = sum(math.hypot(*joint.origin.xyz) for joint in way[first + 1 :])
        self.length = (beyond or 1.0) + math.hypot(*limb.tip.offset)
        above = link_frame(model, self._positions, way[first].parent)
        self.shoulder = within(above, way[first].origin.rotation, way[first].origin.xyz)[1]
        self.tip = self._tip_at(limb.postures.get(limb.start or "", ()))
        ends = map(self._tip_at, limb.postures.values())
        self.lowest = min((end[2] for end in ends), default=self.tip[2])

    def _tip_at(self, posture: Sequence[float]) -> Sequence[float]:
        """Return the position of the tip, m, at a posture, or at first if that is empty."""
        given = dict(zip(self._limb.joints, posture, strict=bool(posture)))
        frame = link_frame(self._model, self._positions | given, self._end.link)
        return within(frame, frame[0], self._end.offset)[1]


def _before(limbs: Sequence[_Limb]) -> Bench:
    if not limbs:
        return _ANY
    length = limbs[0].length
    middle, tip = (
        [math.fsum(each) / len(limbs) for each in zip(*points, strict=True)]
        for points in ([limb.shoulder for limb in limbs], [limb.tip for limb in limbs])
    )
    aside = [tip[0] - middle[0], tip[1] - middle[1]]
    # A tip above its shoulder shows no direction. The table is then ahead of the robot, along x.
    ahead = len(limbs) > 1 or math.hypot(*aside) < _STANDING * length
    axis = 0 if ahead or abs(aside[0]) >= abs(aside[1]) else 1
    sign = 1.0 if ahead else math.copysign(1.0, aside[axis])
    away = min(max(abs(aside[axis]), _AWAY[0] * length), _AWAY[1] * length)
    x, y = (round(middle[each] + (sign * away if each == axis else 0.0), 2) for each in (0, 1))
    thick = round(_THICK * length, 3)
    stands = middle[2] > _BASE * length and tip[2] > _STANDING * length
    lowest = min(limb.lowest for limb in limbs)
    # An arm on a column or a torso works on a table of its own height, and not on the floor.
    standing = round(max(0.0, middle[2] - _DEEPEST * length), 3)
    top = standing if stands else round(lowest - _BELOW * length, 3)
    deep, wide, around = (round(part * length, 2) for part in (_DEEP, _WIDE, _AROUND))
    ball = max(round(_BALL * length, 3), 0.005)
    return Bench(
        (deep, wide, thick) if axis == 0 else (wide, deep, thick),
        (x, y, top - thick / 2),
        (x - around, x + around),
        (y - around, y + around),
        (ball, 1.5 * ball),
        length,
    )


def _centimetres(length: float) -> str:
    return f"{100 * length:.4g} cm"
