"""Whether a schema knows the limits of reach, on all sides and before any arm moves.

The shipped schema of REACHTOUCH runs. If it begins, it tries all allocations, and it was right if
one touches the object. If it refuses at rest, each allocation runs alone, and it was right if none
does. A touch is a reward with all fingertips of one hand, or with both hands, on the object in
truth. An object that no camera finds does not count.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import numpy as np

from cbdsl_reproduction.judges.judge import (
    ANY,
    NONE,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)

if TYPE_CHECKING:
    from cbdsl import EpisodeResult, SimulatedRobot

_SCHEMA = "reachtouch"
# Beginnings of the sentences that name a refusal, and an object that was not found.
_REFUSED, _UNSEEN = "reward is unlikely", "searchtrack has failed"
# Largest motion of a palm in a refused episode, m: a background posture may settle.
_STILL = 0.02
_FINGERS = 3


def verdict_on(
    result: EpisodeResult, moved: float, alone: Mapping[str, bool] | None, *, touched: bool
) -> EpisodeVerdict:
    """Return the verdict on an episode of the schema.

    Args:
        result: Outcome of the schema's own episode.
        moved: Largest motion of a palm in it, m.
        alone: Touch of each allocation alone after a refusal, ``None`` without one.
        touched: True if the episode was rewarded and the object was touched.
    """
    refused = alone is not None
    reachable = any(alone.values()) if alone is not None else touched
    seen = refused or result.rewarded or _UNSEEN not in result.ending
    # A refusal after a motion of the arms came too late.
    begun = not refused or moved > _STILL
    outcomes = {
        "right": (touched if begun else not reachable) if seen else None,
        "rewarded without touch": result.rewarded and not touched if seen else None,
        "refused": refused if seen else None,
        "moved before a refusal": refused and moved > _STILL if seen else None,
        "not found": not seen,
    }
    return EpisodeVerdict(
        result.seed, outcomes, result.sim_seconds, result.ending, context=result.context
    )


class _Palms:
    """Motion of the palms of a robot since the first tick."""

    def __init__(self, simulated: SimulatedRobot) -> None:
        effectors = simulated.robot.request.robot.effectors.values()
        self._truth = simulated.truth
        self._links = [each.tip.link for each in effectors if each.tip is not None]
        self._first: Any = None
        self.moved = 0.0

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        now = np.array([self._truth.link_position(link) for link in self._links])
        self._first = now if self._first is None else self._first
        self.moved = max(self.moved, float(np.linalg.norm(now - self._first, axis=1).max()))


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each context."""
    from cbdsl import load, simulate

    with ExitStack() as stack:

        def opened(program: str, **documents: Any) -> SimulatedRobot:
            request = load(program, stage=condition.stage, **documents)
            made = simulate(request, backend=body.backend, cameras=body.cameras)
            return stack.enter_context(made)

        judged = opened(condition.program, schema=_SCHEMA)
        schema = judged.robot.request.program.schema
        assert schema is not None
        # An allocation that is another program, such as a reach with both hands, runs under its own
        # policy.
        alone = {
            name: opened(values["program"])
            if "program" in values
            else opened(condition.program, policy=schema.policy, values=values)
            for name, values in schema.allocations.items()
        }
        for seed in seeds:
            palms = _Palms(judged)
            result = judged.robot.run(seed, context=condition.context, on_tick=palms.note)
            is_touched = result.rewarded and _is_touched(judged)
            touches = None
            if _REFUSED in result.ending:
                touches = {
                    name: each.robot.run(seed, context=condition.context).rewarded
                    and _is_touched(each)
                    for name, each in alone.items()
                }
            yield verdict_on(result, palms.moved, touches, touched=is_touched)


def _is_touched(simulated: SimulatedRobot) -> bool:
    """Return whether a whole hand, or both hands, touch an object that is no fixture."""
    truth, fixtures = simulated.truth, simulated.robot.request.stage.fixtures
    for name in truth.objects:
        hands = Counter(hand for hand, _ in truth.touching(name)) if name not in fixtures else {}
        if len(hands) > 1 or _FINGERS in hands.values():
            return True
    return False


def _side(name: str) -> JudgedCondition:
    aims = {
        "right": Aim(0.9),
        "rewarded without touch": ANY,
        "refused": ANY,
        "moved before a refusal": NONE,
        "not found": ANY,
    }
    return JudgedCondition(name, "reachtouch", aims, "reach_on_all_sides", context=name)


JUDGE = Judge(
    "reach",
    "limits of reach that a schema predicts, on all sides, before motion",
    tuple(map(_side, ("right", "left", "near", "far"))),
    _measure,
    BodyChoice("kinematic", "ideal"),
    episodes=60,
    knowledge=("schemas/reachtouch.yaml", "policies/reachtouch.yaml"),
)
