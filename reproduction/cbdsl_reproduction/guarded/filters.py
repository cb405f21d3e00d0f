"""Modifiers of a network's reference: random actions, and the filters that others place below.

References and feedbacks are positions of the palm. With ``pace``, a reference asks for the velocity
pace * (reference - feedback): 1 /s for a network of velocities, half of the gain for a spring.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from cbdsl.api.control import Floats
from cbdsl.extend.modifier import ModifierType
from cbdsl_reproduction.guarded.scene import TABLE_BOX, ObstacleBox, drawn_scene

#: Corners of the workspace of the palm in ``push_by_network``, m.
LOW, HIGH = np.array([0.05, -0.62, -0.35]), np.array([0.65, -0.20, 0.0])
# Time for which an action of the network holds, s.
_PERIOD = 0.05
# Largest speed of a clamped reference, m/s: the network moves at up to 0.21 m/s.
_SPEED = 0.25
# Distance that the filter keeps, m, and its rate alpha, 1/s.
_MARGIN, _RATE = 0.01, 5.0
#: Balls around the hand as it pushes, looking down: centres from the palm's position, m, and radii.
HAND = np.array([[0.0, -0.006, 0.019], [0.0, 0.070, -0.004], [0.0, 0.109, -0.009],
                 [0.0, 0.133, -0.039], [0.0, -0.075, -0.006], [0.0, -0.100, -0.033],
                 [0.0, -0.111, -0.074]])  # fmt: skip
RADII = np.array([0.075, 0.040, 0.040, 0.039, 0.020, 0.026, 0.026])

RANDOM_ACTIONS = ModifierType(
    name="random_actions",
    summary="actions of a network of velocities that chance replaces",
    accepts=frozenset({"position"}),
    options={"share": "", "speed": "speed", "seed": ""},
    implementation=f"{__name__}:random_actions",
)
CLAMPED = ModifierType(
    name="clamped",
    summary="a reference clamped to the speed and workspace of cb judge guarded",
    accepts=frozenset({"position"}),
    options={"pace": "rate"},
    implementation=f"{__name__}:clamped",
)
BARRIER = ModifierType(
    name="barrier",
    summary="a reference behind the control barrier functions of a scene of cb judge guarded",
    accepts=frozenset({"position"}),
    options={"pace": "rate", "scene": "", "table": ""},
    implementation=f"{__name__}:barrier",
)


def random_actions(
    reference: Floats, feedback: Floats, time: float, options: Mapping[str, float]
) -> Floats:
    """Return the reference, or during a share of the actions that of a random velocity."""
    action = math.floor(time / _PERIOD + 1e-6)
    rng = np.random.default_rng([int(options["seed"]), action])
    if rng.random() >= options["share"]:
        return reference
    direction = rng.normal(size=3)
    speed = options["speed"] * rng.random()
    changed: Floats = feedback + speed * direction / np.linalg.norm(direction)
    return changed


def clamped(
    reference: Floats, feedback: Floats, time: float, options: Mapping[str, float]
) -> Floats:
    """Return the reference within the workspace, at a speed below the largest one."""
    del time
    way = np.clip(reference, LOW, HIGH) - feedback
    speed = options["pace"] * float(np.linalg.norm(way))
    changed: Floats = feedback + way * min(1.0, _SPEED / max(speed, 1e-9))
    return changed


def barrier(
    reference: Floats, feedback: Floats, time: float, options: Mapping[str, float]
) -> Floats:
    """Return the nearest reference whose velocity keeps the hand apart from the obstacles.

    An end-effector filter after AEGIS (arXiv 2512.11891): it knows the hand and no other link. The
    option ``table`` is 1 if the table is an obstacle, too, and otherwise 0.
    """
    del time
    pace, scene = options["pace"], drawn_scene(int(options["scene"]))
    table = (TABLE_BOX,) if options["table"] == 1 else ()
    rows, least = barriers(feedback, (*table, *scene.obstacles.values()))
    changed: Floats = feedback + safe_velocity(pace * (reference - feedback), rows, least) / pace
    return changed


def barriers(palm: Floats, boxes: Sequence[ObstacleBox]) -> tuple[Floats, Floats]:
    """Return the constraints rows @ velocity >= least of the hand at a place.

    Each ball of the hand has a barrier function h to each box: its distance less the margin. The
    gradient of h is the outward normal, so that dh/dt >= -alpha h is linear in the velocity. The
    faces of the workspace are barriers of the palm.

    Args:
        palm: Position of the palm, m, shape (3,).
        boxes: Obstacles.

    Returns:
        Unit rows, shape (k, 3), and least velocities along them, m/s, shape (k,).
    """
    rows, heights = [*np.eye(3), *-np.eye(3)], [*(palm - LOW), *(HIGH - palm)]
    for box in boxes:
        for centre, radius in zip(palm + HAND, RADII, strict=True):
            normal, distance = signed_distance(centre, box)
            rows.append(normal)
            heights.append(distance - radius - _MARGIN)
    return np.array(rows), -_RATE * np.array(heights)


def signed_distance(point: Floats, box: ObstacleBox) -> tuple[Floats, float]:
    """Return the outward normal of a box at a point, and the distance, m, negative inside."""
    away = point - box.nearest(point)
    distance = float(np.linalg.norm(away))
    if distance > 0.0:
        return away / distance, distance
    # Inside, the nearest face leads out.
    offset = point - box.centre
    depths = box.halves - np.abs(offset)
    axis = int(np.argmin(depths))
    normal = np.zeros(3)
    normal[axis] = math.copysign(1.0, offset[axis])
    return normal, -float(depths[axis])


def safe_velocity(velocity: Floats, rows: Floats, least: Floats) -> Floats:
    """Return the nearest velocity v with rows @ v >= least, or 0 if there is none, m/s, shape (3,).

    Args:
        velocity: Requested velocity, m/s, shape (3,).
        rows: Unit rows of the constraints, shape (k, 3).
        least: Least velocities along them, m/s, shape (k,).
    """
    from qpsolvers import solve_qp

    safe = solve_qp(np.eye(3), -velocity, -rows, -least, solver="quadprog")
    return np.zeros(3) if safe is None else safe
