"""Whether ``set_on`` inserts an object into a hole, by clearance.

An object is inserted if it ends at least 2 cm below the rim, tilted by less than 10 degrees. The
program does not search for the hole.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from cbdsl import load, simulate
from cbdsl_reproduction.judges.judge import (
    ANY,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)
from cbdsl_reproduction.judges.watch import Watch, watch_episode

if TYPE_CHECKING:
    from cbdsl import EpisodeResult
    from cbdsl.api.documents import StageDocument

# Contexts of the stage, with the object that has the hole.
_HOLES = {"cylinder_in_cylinder": "tube", "box_in_box": "tray"}
# Half sizes of the inserted objects, wall of the hole, and half heights of both, m.
_HALF, _WALL, _RIM, _TALL = 0.04, 0.01, 0.05, 0.08
_DEEP, _UPRIGHT = 0.02, math.radians(10.0)
_AIMS = {2: ANY, 5: ANY, 10: Aim(0.8), 20: Aim(0.95)}  # by clearance, mm


def widened(stage: StageDocument, clearance: float) -> StageDocument:
    """Return the stage with holes that leave a clearance on every side, m."""
    outer = _HALF + clearance + _WALL
    tube, tray = (stage.things[name] for name in _HOLES.values())
    edges = ((2 * outer,) * 2, (2 * outer,) * 2, (2 * _RIM,) * 2)
    forms = (
        tube.form.model_copy(update={"radius": (outer, outer)}),
        tray.form.model_copy(update={"size": edges}),
    )
    things = {
        name: stage.things[name].model_copy(update={"form": form})
        for name, form in zip(_HOLES.values(), forms, strict=True)
    }
    return stage.model_copy(update={"things": {**stage.things, **things}})


class _Inside(Watch):
    """Final pose of the inserted object in the hole."""

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the object is in the hole."""
        top, base = self.truth.position("top"), self.truth.position("base")
        # Depth of the lower face of the object below the rim of the hole.
        deep = float((base[2] + _RIM) - (top[2] - _TALL))
        tilt = math.acos(min(1.0, float(self.truth.rotation("top")[2, 2])))
        # An object beside the hole may lie as deep, so that its centre has to be within the hole.
        is_inside = deep > _DEEP and tilt < _UPRIGHT and math.dist(top[:2], base[:2]) < _HALF
        return EpisodeVerdict(
            result.seed,
            {"inserted": is_inside},
            result.sim_seconds,
            result.ending,
            {"depth_mm": 1e3 * deep},
        )


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each insertion."""
    from cbdsl_reproduction.thing_pairs import PAIRS

    clearance = float(condition.name.split()[1]) / 1e3
    assert condition.context is not None
    values = PAIRS[condition.context].values
    request = load(condition.program, stage=condition.stage, values=values)
    request = replace(request, stage=widened(request.stage, clearance))
    with simulate(request, backend=body.backend, cameras=body.cameras) as simulated:
        for seed in seeds:
            yield watch_episode(simulated, _Inside(simulated, condition, body), seed)


JUDGE = Judge(
    "insertion",
    "a cylinder and a box put into holes of several clearances",
    tuple(
        JudgedCondition(
            f"{context.partition('_')[0]} {clearance} mm",
            "set_on",
            {"inserted": aim},
            "pairs",
            context,
        )
        for clearance, aim in _AIMS.items()
        for context in _HOLES
    ),
    _measure,
    BodyChoice("mujoco", "ideal"),
)
