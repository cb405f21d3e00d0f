"""REACHTOUCH with TACTILEPROBE in place of TOUCH (Figure 5.12)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from typing import Any

from cbdsl import Transition
from cbdsl.api.allocation import exchanged
from cbdsl.api.control import Kinematics
from cbdsl.api.learning import Experience
from cbdsl.api.program import Action, CheckedProgram, Composition, Primitive, own_policy
from cbdsl.api.shipped import shipped_program
from cbdsl.api.trials import EPISODES, BackendEpisodeRunner, Journal, embody
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.diagram import Diagram, graph_of
from cbdsl_reproduction.estimate import mean_of
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above
from cbdsl_reproduction.trial_digest import trial_digest

_PROGRAM, _MEMBER, _PROBE, _STAGE = "reachtouch", "touch", "tactileprobe", "small_on_table"
_EPISODES, _QUICK = 60, 2
_LIMITS: dict[str, Any] = {"transition_time": 30.0, "idle_time": 1.0, "transitions": 30}
PASSIVE, SEEKING, PROBING = "passive", "seeking", "probing"
_NAMES = {
    PASSIVE: "TOUCH that acts on contact only",
    SEEKING: "TOUCH that closes the fingers until there is contact",
    PROBING: "TACTILEPROBE in the place of TOUCH",
}
_PLACE = "Section 5.3.2, Figure 5.12"
_MORE = {
    other: Claim(
        _PLACE,
        f"rewarded episodes, {_NAMES[PROBING]} minus {_NAMES[other]}",
        "%",
        "more",
        above(0),
    )
    for other in (PASSIVE, SEEKING)
}
_REWARDED = Claim(_PLACE, "{context}, {way}: rewarded", "%")
CLAIMS: Claims = {
    "fig-5.12": (*_MORE.values(), *(_REWARDED.named(way=way) for way in _NAMES.values()))
}

Outcomes = Mapping[str, Sequence[Experience]]
"""Episodes of the same seeds, by the way of making contact."""


def run(settings: RunSettings) -> Result:
    """Reach, and make contact in three ways."""
    programs = reparameterised()
    episodes = {way: tuple(_episodes(settings, way, each)) for way, each in programs.items()}
    graph = graph_of(_PROGRAM, programs[PROBING], episodes[PROBING])
    title = f"REACHTOUCH with {_PROBE} in the place of {_MEMBER}, {len(episodes[PROBING])} episodes"
    diagram = Diagram("fig-5.12", title, graph)
    return Result(tuple(quantities(episodes, settings.seed)), (diagram,), _NOTES)


_NOTES = (
    f"Program {_PROGRAM} under its learned policy on stage {_STAGE}: a ball that fills the hand in "
    "half of the episodes, a small one in the other half, the same in all three series. "
    f"{_PROBE.capitalize()} may replace {_MEMBER} because both are rewarded for the quiescence of "
    "a spring on the fingers' forces, by the hand.",
    "The source's TOUCH acts on contact that REACH has brought about. That of the shipped program "
    "closes the fingers once the hand has arrived, in a direction that its author knows; "
    "TACTILEPROBE draws postures of the hand until some bring contact. The claim of the source, "
    "that the probe works in more cases, is judged beside both: the TOUCH it describes, which "
    "does not close them, and the shipped one, which already contains most of the probe's effect.",
    "REACH goes on while TACTILEPROBE runs, which begins when REACH has come to rest. Its reward "
    "counts as that of the controller whose place it has.",
)


def reparameterised() -> dict[str, CheckedProgram]:
    """Return the shipped program in three variants, by the way of making contact."""
    own = shipped_program(_PROGRAM, stage=_STAGE, policy=_PROGRAM)
    probing = exchanged(own, _MEMBER, _PROBE)
    ways = {PASSIVE: _without_seeking(own.program), SEEKING: own.program, PROBING: probing}
    return {way: program._replace(**_LIMITS) for way, program in ways.items()}


def _without_seeking(program: CheckedProgram) -> CheckedProgram:
    """Return the program with a TOUCH that acts only on measured contact."""
    actions = tuple(map(_passive_action, program.actions))
    primitives = {name: _passive(each) for name, each in program.primitives.items()}
    return program._replace(actions=actions, primitives=primitives)


def _passive_action(action: Action) -> Action:
    if action.composition is None:
        return action
    return action._replace(composition=Composition(tuple(map(_passive, action.composition[0]))))


def _passive(primitive: Primitive) -> Primitive:
    return primitive._replace(
        controllers=tuple(replace(each, seek=None) for each in primitive.controllers)
    )


def _episodes(settings: RunSettings, way: str, program: CheckedProgram) -> Iterator[Experience]:
    """Yield the episodes of one way, from the file or by running them."""
    usual = _QUICK if settings.quick else _EPISODES
    count = settings.trials or usual
    cameras = settings.cameras or "ideal"
    identity = {
        "what": trial_digest(_PROGRAM, {}, _STAGE),
        "stand-in": trial_digest(_PROBE, {}, _STAGE),
        "way": way,
        "limits": _LIMITS,
        "policy": dict(program.policy),
        "seed": settings.seed,
        "body": [settings.backend, cameras],
    }
    done = list(_NAMES).index(way) * count
    path = settings.folder / f"fig_5_12_{settings.backend}_{settings.seed}_{way}.jsonl"
    with Journal(path, identity, EPISODES) as journal:
        kept = journal.rows[:count]
        yield from kept
        if len(kept) == count:
            return
        at = shipped_program(_PROGRAM, stage=_STAGE)
        with closing(embody(settings.backend, at.robot, at.urdf, cameras=cameras)) as body:
            kinematics = Kinematics(at.robot, at.urdf)
            runner = BackendEpisodeRunner(at.robot, kinematics, body, at.stage)
            for number in range(len(kept), count):
                seed = settings.seed + number
                experience = runner.run(program, own_policy(program), seed, _ignore)
                journal.append(experience)
                settings.progress(done + number + 1, len(_NAMES) * count)
                yield experience


def quantities(episodes: Outcomes, seed: int) -> Iterator[Quantity]:
    """Yield the gains of the probe over either TOUCH, and the share of rewards of each way.

    Section 5.3.2 claims that the probe works in more cases than TOUCH.
    """
    yield from (_more(episodes, other, seed) for other in _MORE)
    contexts = sorted({each.context for each in episodes[PROBING]})
    for way, context in ((way, context) for way in _NAMES for context in contexts):
        own = [each for each in episodes[way] if each.context == context]
        hits = sum(each.reward > 0 for each in own)
        claim = _REWARDED.named(context=context, way=_NAMES[way])
        yield percentage(claim, hits, len(own))


def _more(episodes: Outcomes, other: str, seed: int) -> Quantity:
    # Episodes of the same seed have the same ball. Differences of such pairs vary less than
    # differences of two independent shares.
    pairs = zip(episodes[PROBING], episodes[other], strict=True)
    gains = [100.0 * ((one.reward > 0) - (two.reward > 0)) for one, two in pairs]
    return mean_of(_MORE[other], gains, seed=seed)


def _ignore(transition: Transition) -> None:
    """Ignore a transition: nothing is learned."""
