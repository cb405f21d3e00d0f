"""Shipped programs and policies of Dexter on every engine, with rendered and ideal cameras."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from statistics import median
from typing import NamedTuple

from cbdsl import Truth
from cbdsl.api.control import Kinematics, read_urdf
from cbdsl.api.documents import (
    PolicyDocument,
    ProgramDocument,
    RobotDocument,
    StageDocument,
    digest_of_text,
)
from cbdsl.api.program import CheckedProgram
from cbdsl.api.sensing import EpisodeListeners, Runner
from cbdsl.api.shipped import (
    shipped_document,
    shipped_names,
    shipped_program,
    shipped_robot,
)
from cbdsl.api.trials import embody_simulated, find_backend
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.kept_episodes import KeptEpisodes, PlayedEpisode
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above
from cbdsl_reproduction.slip_gauge import SlipGauge, palms

Episodes = Sequence[PlayedEpisode]

_EPISODES, _QUICK_EPISODES = 20, 1
_WORSE = 20.0  # points of percentage below the reference, by which a share is worse
_ROBOT = "dexter"
# Other bodies than the reference: their region is bound by the share of the reference.
_AGREES = Claim("Sections 4.2 and 4.3", "{part}: succeeds", "%", "{reference}", bound=above)
CLAIMS: Claims = {"engines": (_AGREES,)}

_NOTES = (
    "Every program that has a stage runs there under its own policy, and every policy on the stage "
    "that it was learned on. All bodies run the same seeds, which show the same things at the same "
    "places. A program succeeds where it is rewarded, comes to a state of success if it names any, "
    "or comes to rest at its end where nothing rewards it.",
    "The first body is the reference. The others agree with it where all of their interval is "
    f"above its share less {_WORSE:g} points; programs that never succeed there, such as one that "
    "follows a ball until its time is over, are not judged. Notes give the number of episodes that "
    "pass the same states in the same order, the simulated and the wall time of an episode, the "
    "slip of a carried object in the hand (median of the largest in an episode, and the largest "
    "of all), and the most frequent final state of failed episodes.",
    "States differ although both succeed where contacts come some ticks sooner, as without "
    "inertia on the kinematic body, where soft contacts chatter, and where references are drawn at "
    "random, since the draws depend on the seen objects.",
)


class EngineSetup(NamedTuple):
    """Backend and its cameras, by name."""

    backend: str
    cameras: str

    def __str__(self) -> str:
        return f"{self.backend}, {self.cameras} cameras"


_SETUPS = (
    EngineSetup("bullet", "rendered"),
    EngineSetup("mujoco", "rendered"),
    EngineSetup("mujoco", "ideal"),
    EngineSetup("kinematic", "ideal"),
)


class PlayedPart(NamedTuple):
    """Program under one policy, and its stage.

    Attributes:
        name: Name of the program or policy.
        program: Program with that policy.
        stage: Stage on which it runs.
        digest: Digest of program and policy.
    """

    name: str
    program: CheckedProgram
    stage: StageDocument
    digest: str

    def digest_with(self, robot: RobotDocument, setup: EngineSetup) -> str:
        """Return the digest of all inputs of an episode except its seed."""
        documents = [each.model_dump_json() for each in (robot, self.stage)]
        return digest_of_text("\n".join([self.digest, str(setup), *documents]))


def run(settings: RunSettings) -> Result:
    """Run all shipped programs and policies of Dexter on all engines."""
    episodes = settings.trials or (_QUICK_EPISODES if settings.quick else _EPISODES)
    seeds = range(settings.seed, settings.seed + episodes)
    parts = list(_parts())
    for setup in _SETUPS:
        find_backend(setup.backend)  # reports a missing installation before any run
    played: dict[EngineSetup, dict[str, Episodes]] = {setup: {} for setup in _SETUPS}
    for number, setup in enumerate(_SETUPS):
        kept = KeptEpisodes(settings.folder / f"{setup.backend}_{setup.cameras}.jsonl")
        body = EmbodiedRobot(setup)
        for index, part in enumerate(parts):
            what = part.digest_with(body.robot, setup)
            play = body.player(part)
            played[setup][part.name] = [kept.run(what, seed, partial(play, seed)) for seed in seeds]
            settings.progress(number * len(parts) + index + 1, len(_SETUPS) * len(parts))
        body.backend.close()
    return Result(tuple(_quantities(played)), notes=_NOTES)


class EmbodiedRobot:
    """Robot on one engine.

    Args:
        setup: Engine and its cameras.
    """

    def __init__(self, setup: EngineSetup) -> None:
        self.robot, self._urdf = shipped_robot(_ROBOT)
        self._hands = palms(self.robot, read_urdf(self._urdf))
        self.backend = embody_simulated(
            setup.backend, self.robot, self._urdf, cameras=setup.cameras
        )

    def player(self, part: PlayedPart) -> Callable[[int], PlayedEpisode]:
        """Return a function that plays an episode of a part, by its seed."""
        kinematics = Kinematics(self.robot, self._urdf)
        runner = Runner(self.robot, kinematics, part.program, self.backend)
        fixtures = frozenset(part.stage.fixtures)

        def play(seed: int) -> PlayedEpisode:
            slip = SlipGauge(Truth(self.backend.truth), self._hands, fixtures)
            result = runner.run(part.stage, seed, observer=EpisodeListeners(on_tick=slip.watch))
            return PlayedEpisode(result, result.rewarded or runner.predicate == "1", slip.largest)

        return play


def _parts() -> Iterator[PlayedPart]:
    for name in shipped_names(ProgramDocument):
        document = shipped_document(ProgramDocument, name)
        if document.stage is None or document.robot not in (_ROBOT, ""):
            continue
        request = shipped_program(name)
        if request.program.robot == _ROBOT:
            digest = digest_of_text(str(request.digest))
            own = digest + request.program_file.read_text(encoding="utf-8")
            yield PlayedPart(name, request.program, request.stage, own)
    for name in shipped_names(PolicyDocument):
        policy = shipped_document(PolicyDocument, name)
        learned = policy.provenance
        if learned is not None:
            request = shipped_program(policy.program, stage=learned.stage.name, policy=name)
            digest = str(request.digest) + policy.model_dump_json()
            yield PlayedPart(f"policy {name}", request.program, request.stage, digest)


def _quantities(played: Mapping[EngineSetup, Mapping[str, Episodes]]) -> Iterator[Quantity]:
    """Yield the shares of successful episodes, part by part."""
    first, *others = _SETUPS
    for name, reference in played[first].items():
        share = 100 * sum(each.done for each in reference) / len(reference)
        yield _success(name, first, reference, reference, "the reference")
        for setup in others:
            source = f"{first.backend}: {share:.0f} %"
            yield _success(name, setup, played[setup][name], reference, source)


def _success(
    name: str, setup: EngineSetup, episodes: Episodes, reference: Episodes, source: str
) -> Quantity:
    hits, share = (sum(each.done for each in group) for group in (episodes, reference))
    # A share of 0 on the reference bounds nothing: any body would agree with it.
    judged = share and episodes is not reference
    claim = _AGREES.named(part=f"{name} on {setup}", reference=source)
    if judged:
        claim = claim.at(100 * share / len(reference) - _WORSE)
    note = "; ".join((*_times(episodes, reference), *_slips(episodes), *_ending(episodes)))
    return percentage(claim, hits, len(episodes), note=note)


def _times(episodes: Episodes, reference: Episodes) -> Iterator[str]:
    """Yield the number of episodes with the reference's states, and the time of an episode."""
    results = [each.result for each in episodes]
    same = sum(
        one.predicates == other.result.predicates
        for one, other in zip(results, reference, strict=True)
    )
    simulated = sum(each.sim_seconds for each in results) / len(results)
    wall = sum(each.wall_seconds for each in results) / len(results)
    if episodes is not reference:
        yield f"same states in {same}"
    yield f"{simulated:.1f} s simulated in {wall:.2f} s"


def _slips(episodes: Episodes) -> Iterator[str]:
    """Yield the slip of carried objects, if there are any."""
    slips = [1e3 * each.slip for each in episodes if each.slip is not None]
    if slips:
        yield f"slips {median(slips):.1f} mm, at most {max(slips):.1f} mm"


def _ending(episodes: Episodes) -> Iterator[str]:
    """Yield the state in which most failed episodes end, if there are any."""
    last = Counter(each.result.predicates[-1] for each in episodes if not each.done)
    for state, count in last.most_common(1):
        yield f"{count} of {last.total()} others end in {state}"
