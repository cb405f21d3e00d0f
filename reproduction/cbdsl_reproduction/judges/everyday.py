"""Whether ``deliver`` places everyday objects, or refuses them before an arm moves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl import load, simulate
from cbdsl_reproduction.judges.claim_judges import ClaimWatch, delivered
from cbdsl_reproduction.judges.judge import (
    ANY,
    NONE,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)

# Largest turn of an arm's joint without motion, rad.
_STILL = 0.05
_PROGRAM, _STAGE = "deliver", "everyday_objects"


class _Stillness:
    """Largest turn of the arms' joints in an episode."""

    def __init__(self) -> None:
        self._first: NDArray[np.float64] | None = None
        self.turn = 0.0

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        joints = tick.signals.joints
        arms = [k for arm in ("left_arm", "right_arm") for k in joints.of(arm)]
        now = tick.observation.positions[arms]
        if self._first is None:
            self._first = now.copy()
        self.turn = max(self.turn, float(np.abs(now - self._first).max()))


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each episode with each object."""
    request = load(_PROGRAM, stage=condition.stage)
    with simulate(request, backend=body.backend, cameras=body.cameras) as simulated:
        for context, shown in request.stage.contexts.items():
            for seed in seeds:
                names = [*(shown.placed or ()), *request.stage.things]
                watch, still = ClaimWatch(simulated.truth, names), _Stillness()

                def note(tick: Any, watch: ClaimWatch = watch, still: _Stillness = still) -> None:
                    watch.note(tick)
                    still.note(tick)

                result = simulated.robot.run(seed, context=context, on_tick=note)
                is_success = result.outcome == "success"
                fault = delivered(watch) if is_success else ""
                is_refused = result.outcome == "failure" and still.turn < _STILL
                outcomes = {
                    "placed": is_success and not fault,
                    "refused before motion": is_refused,
                    "placed or refused": (is_success and not fault) or is_refused,
                    "false success": bool(fault),
                }
                ending = fault or result.ending
                yield EpisodeVerdict(seed, outcomes, result.sim_seconds, ending, context=context)


JUDGE = Judge(
    "everyday",
    "everyday objects placed on a pad, or refused before motion",
    (
        JudgedCondition(
            "all objects",
            _PROGRAM,
            {
                "placed": ANY,
                "refused before motion": ANY,
                "placed or refused": Aim(0.9),
                "false success": NONE,
            },
            _STAGE,
        ),
    ),
    _measure,
    BodyChoice("mujoco", "ideal"),
)
