"""Whether claims of success agree with the world.

A program claims success if it ends as achieved: by its ``success`` if it states one, otherwise by
its reward, or as done. A missing claim is not a fault here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from cbdsl import load, simulate
from cbdsl_reproduction.judges.claim_judges import (
    CLAIMS,
    ON_OTHER_ROBOTS,
    ClaimWatch,
    ProgramClaim,
)
from cbdsl_reproduction.judges.judge import (
    ANY,
    NONE,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)

if TYPE_CHECKING:
    from cbdsl import RunRequest, SimulatedRobot

_ALL = (*CLAIMS, *ON_OTHER_ROBOTS)
_BY_NAME = {claim.name: claim for claim in _ALL}


def contexts_of(claim: ProgramClaim) -> Sequence[str]:
    """Return the contexts in which a claim is judged."""
    return claim.contexts or tuple(_load(claim, {}).stage.contexts)


def _load(claim: ProgramClaim, values: Mapping[str, str]) -> RunRequest:
    return load(claim.program, stage=claim.stage, values=values, robot=claim.robot or None)


def judge_claims(
    claim: ProgramClaim, body: BodyChoice, seeds: Sequence[int], contexts: Sequence[str]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each episode of a program in some contexts."""
    for context in contexts:
        request = _load(claim, claim.values(context))
        with simulate(request, backend=body.backend, cameras=body.cameras) as simulated:
            for seed in seeds:
                yield _judge_episode(claim, simulated, context, seed)


def _judge_episode(
    claim: ProgramClaim, simulated: SimulatedRobot, context: str, seed: int
) -> EpisodeVerdict:
    stage = simulated.robot.request.stage
    names = [*(stage.contexts[context].placed or ()), *stage.things]
    watch, last = ClaimWatch(simulated.truth, names), [""]

    def note(tick: Any) -> None:
        watch.note(tick)
        last[0] = tick.run.predicate

    result = simulated.robot.run(seed, context=context, on_tick=note)
    is_claimed = last[0] == "1"
    fault = claim.judge(watch) if is_claimed else ""
    return EpisodeVerdict(
        seed,
        {"claimed": is_claimed, "false claim": bool(fault)},
        result.sim_seconds,
        fault or result.ending,
        context=context,
    )


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    claim = _BY_NAME[condition.name]
    yield from judge_claims(claim, body, seeds, contexts_of(claim))


JUDGE = Judge(
    "claims",
    "claims of success of each shipped program, in each context of a stage",
    tuple(
        JudgedCondition(
            claim.name, claim.program, {"claimed": ANY, "false claim": NONE}, claim.stage
        )
        for claim in _ALL
    ),
    _measure,
    BodyChoice("mujoco", "ideal"),
    episodes=4,
)
