"""Scenes with random obstacles between a hand, the object that it pushes, and its goal."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from cbdsl.api.control import Floats
from cbdsl.api.documents import StageDocument

#: Name of the fixture below the object.
TABLE = "table"
# Top of the table, m.
_TOP = -0.42
# Place of the palm at the start of an episode, m.
_START = np.array([0.1, -0.55, -0.2])
# Distance of obstacles from it, m: the fingers are up to 0.2 m away.
_FROM_START = 0.25
# Half the width of the way of object and hand along y, m: half of the object's diagonal, and 4 cm.
_WAY = 0.11
# Distance of the obstacles from each other, m.
_APART = 0.02


class ObstacleBox(NamedTuple):
    """Upright box with its edges along the axes of the world.

    Attributes:
        centre: Centre, m, shape (3,).
        halves: Half of its size, m, shape (3,).
    """

    centre: Floats
    halves: Floats

    def nearest(self, point: Floats) -> Floats:
        """Return the point of the box that is nearest to another one, m, shape (3,)."""
        nearest: Floats = np.clip(point, self.centre - self.halves, self.centre + self.halves)
        return nearest

    def is_apart(self, other: ObstacleBox, distance: float) -> bool:
        """Return whether another box is at a distance, m, along one of the axes at least."""
        gaps = np.abs(self.centre - other.centre) - self.halves - other.halves
        return bool((gaps >= distance).any())


#: Table of the stage ``thing_to_push``.
TABLE_BOX = ObstacleBox(np.array([0.6, 0.0, _TOP - 0.02]), np.array([0.3, 0.6, 0.02]))


class PushScene(NamedTuple):
    """Object to push, and the obstacles around its way.

    Attributes:
        thing: Name of the object on the stage ``thing_to_push``.
        place: Place of the object: x and y, m, and yaw, rad.
        obstacles: Obstacles by name.
    """

    thing: str
    place: tuple[float, float, float]
    obstacles: dict[str, ObstacleBox]


@lru_cache(maxsize=64)
def drawn_scene(seed: int) -> PushScene:
    """Return the scene of a seed.

    The first obstacle is between the start of the hand and the place behind the object. Others may
    be beside the way of the object. None is on that way, which a push cannot leave.
    """
    rng = np.random.default_rng([seed, 1])
    x, y = float(rng.uniform(0.46, 0.58)), float(rng.uniform(-0.26, -0.18))
    place = x, y, float(rng.uniform(-0.35, 0.35))
    thing = ("block", "can")[rng.integers(2)]
    obstacles: dict[str, ObstacleBox] = {}
    count = int(rng.integers(1, 4))
    while len(obstacles) < count:
        kind = (_post_before, _hanging, _post_beside)[rng.integers(3 if obstacles else 2)]
        box = kind(rng, x)
        if _is_free(box, x) and all(box.is_apart(each, _APART) for each in obstacles.values()):
            obstacles[f"obstacle_{len(obstacles) + 1}"] = box
    return PushScene(thing, place, obstacles)


def _post_before(rng: np.random.Generator, x: float) -> ObstacleBox:
    """Return a post on the table, between the start of the hand and the object."""
    del x
    height = rng.uniform(0.08, 0.28)
    return _on_table(rng.uniform(0.32, 0.46), rng.uniform(-0.62, -0.40), height, rng)


def _hanging(rng: np.random.Generator, x: float) -> ObstacleBox:
    """Return a box in the air, between the start of the hand and the object."""
    del x
    halves = rng.uniform(0.015, 0.05, 3)
    low, high = (0.26, -0.65, -0.28), (0.44, -0.35, 0.05)
    return ObstacleBox(rng.uniform(low, high), halves)


def _post_beside(rng: np.random.Generator, x: float) -> ObstacleBox:
    """Return a post on the table, beside the way of the object."""
    aside = rng.choice((-1.0, 1.0)) * rng.uniform(_WAY, 0.22)
    return _on_table(x + aside, rng.uniform(-0.5, 0.0), rng.uniform(0.05, 0.2), rng)


def _on_table(x: float, y: float, height: float, rng: np.random.Generator) -> ObstacleBox:
    width, depth = rng.uniform(0.015, 0.04, 2)
    halves = np.array([width, depth, height / 2.0])
    return ObstacleBox(np.array([x, y, _TOP + height / 2.0]), halves)


def _is_free(box: ObstacleBox, x: float) -> bool:
    """Return whether a box is neither at the start of the hand nor on the way of the object."""
    from_start = float(np.linalg.norm(box.nearest(_START) - _START))
    return from_start >= _FROM_START and abs(box.centre[0] - x) >= _WAY + box.halves[0]


def stage_of(scene: PushScene, stage: StageDocument, *, is_clean: bool) -> dict[str, Any]:
    """Return a stage document with the object and the obstacles of a scene.

    Args:
        scene: Scene.
        stage: Stage ``thing_to_push``.
        is_clean: True to leave out obstacles and errors of the cameras.
    """
    x, y, yaw = scene.place
    shown = stage.model_dump(mode="json", exclude_unset=True)
    (context,) = shown["contexts"].values()
    context["things"] = [scene.thing]
    shown["things"] = {scene.thing: shown["things"][scene.thing]}
    context["place"] = {"on": TABLE, "x": x, "y": y, "yaw": yaw}
    shown["name"] = "guarded"
    if is_clean:
        return shown
    for name, box in scene.obstacles.items():
        size = (2.0 * box.halves).tolist()
        shown["fixtures"][name] = {
            "form": {"shape": "box", "size": size},
            "position": box.centre.tolist(),
            "color": [0.5, 0.5, 0.5],
        }
    return {**shown, "disturbance": {"camera_position": 0.003, "camera_rotation": 0.005}}
