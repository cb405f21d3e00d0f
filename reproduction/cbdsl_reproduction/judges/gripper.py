"""Whether ``pick`` puts a cube within 2 cm of its place, flat on the table."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from cbdsl_reproduction.judges.judge import Aim, EpisodeVerdict, Judge, JudgedCondition
from cbdsl_reproduction.judges.watch import Watch, watched

if TYPE_CHECKING:
    from cbdsl import EpisodeResult

_PLACE, _CLOSE = (0.49, 0.294), 0.02  # m
_FLAT = math.radians(10.0)


class _Cube(Watch):
    """Final pose of the cube."""

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the cube is at its place."""
        position, rotation = self.truth.position("cube"), self.truth.rotation("cube")
        error = math.dist(position[:2], _PLACE)
        # Any side may be below; the sides are equal.
        half = float(self.truth.half_extents("cube")[2])
        tilt = math.acos(min(1.0, float(np.abs(rotation[2]).max())))
        is_flat = tilt < _FLAT and abs(float(position[2]) - half) < _CLOSE / 4
        return EpisodeVerdict(
            result.seed,
            {"placed": error < _CLOSE and is_flat},
            result.sim_seconds,
            result.ending,
            {"error_mm": 1e3 * error},
        )


JUDGE = Judge(
    "gripper",
    "a cube that a Panda picks up and places",
    (JudgedCondition("cube", "pick", {"placed": Aim(0.95)}, values={"robot": "panda"}),),
    watched(_Cube),
    episodes=100,
)
