"""The shipped programs and policies of Dexter on every engine, with rendered and ideal cameras."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import NamedTuple

from cbdsl.backends.backend import embody
from cbdsl.checking.knowledge.digest import program_digest
from cbdsl.checking.knowledge.learned import with_policy
from cbdsl.checking.program import check_program
from cbdsl.documents.digest import digest_of_text
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.reproduction.claim import above
from cbdsl.reproduction.experiment import Result, RunSettings
from cbdsl.reproduction.kept_episodes import KeptEpisodes
from cbdsl.reproduction.percentage import percentage
from cbdsl.reproduction.quantity import Quantity
from cbdsl.reproduction.shipped import shipped_file, shipped_robot
from cbdsl.runtime.episode import EpisodeResult, Runner
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.yaml_text.library import Library, shipped

Episodes = Sequence[EpisodeResult]

_EPISODES, _QUICK_EPISODES = 20, 1
_WORSE = 20.0  # points of percentage below the reference, by which a share is worse
_ROBOT = "dexter"

_NOTES = (
    "Every program that has a stage runs there under its own policy, and every policy on the stage "
    "that it was learned on. All bodies run the same seeds, which show the same things at the same "
    "places.",
    "The first body is the reference. The others agree with it where all of their interval is "
    f"above its share less {_WORSE:g} points. Notes give the number of episodes that pass the same "
    "states in the same order, the simulated time of an episode, how many times faster than real "
    "time it runs here, and the state in which most episodes end that are not rewarded.",
)


class EngineSetup(NamedTuple):
    """A backend and its cameras, by name."""

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
    """A program under one policy, and the stage that it runs on.

    Attributes:
        name: of the program or policy.
        program: with that policy.
        stage: where it runs.
        digest: of program and policy.
    """

    name: str
    program: CheckedProgram
    stage: StageDocument
    digest: str

    def digest_with(self, robot: RobotDocument, setup: EngineSetup) -> str:
        """Digest of all that decides an episode beside its seed."""
        documents = [each.model_dump_json() for each in (robot, self.stage)]
        return digest_of_text("\n".join([self.digest, str(setup), *documents]))


def run(settings: RunSettings) -> Result:
    """Run everything that is shipped for Dexter on all engines."""
    episodes = settings.trials or (_QUICK_EPISODES if settings.quick else _EPISODES)
    seeds = range(settings.seed, settings.seed + episodes)
    library = Library(shipped())
    parts = list(_parts(library))
    played: dict[EngineSetup, dict[str, Episodes]] = {setup: {} for setup in _SETUPS}
    for number, setup in enumerate(_SETUPS):
        robot, urdf = shipped_robot(_ROBOT, library)
        kept = KeptEpisodes(settings.folder / f"{setup.backend}_{setup.cameras}.jsonl")
        backend = embody(setup.backend, robot, urdf, cameras=setup.cameras)
        for index, part in enumerate(parts):
            runner = Runner(robot, Kinematics(robot, urdf), part.program, backend)
            what = part.digest_with(robot, setup)
            played[setup][part.name] = [
                kept.run(what, seed, partial(runner.run, part.stage, seed)) for seed in seeds
            ]
            settings.progress(number * len(parts) + index + 1, len(_SETUPS) * len(parts))
        backend.close()
    return Result(tuple(_quantities(played)), notes=_NOTES)


def _parts(library: Library) -> Iterator[PlayedPart]:
    for name in library.names(ProgramDocument):
        file = shipped_file(library, ProgramDocument, name)
        program = check_program(file, {}, library)
        if program.robot == _ROBOT and program.stage is not None:
            digest = digest_of_text(str(program_digest(file, library)))
            own = digest + file.read_text(encoding="utf-8")
            yield PlayedPart(name, program, _stage(library, program.stage), own)
    for name in library.names(PolicyDocument):
        loaded = library.read(shipped_file(library, PolicyDocument, name), PolicyDocument)
        learned = loaded.document.provenance
        if learned is not None:
            file = shipped_file(library, ProgramDocument, loaded.document.program)
            program = with_policy(check_program(file, {}, library), loaded, library)
            digest = str(program_digest(file, library)) + loaded.document.model_dump_json()
            yield PlayedPart(f"policy {name}", program, _stage(library, learned.stage.name), digest)


def _stage(library: Library, name: str) -> StageDocument:
    return library.read(shipped_file(library, StageDocument, name), StageDocument).document


def _quantities(played: Mapping[EngineSetup, Mapping[str, Episodes]]) -> Iterator[Quantity]:
    """The shares of rewarded episodes, part by part."""
    first, *others = _SETUPS
    for name, reference in played[first].items():
        share = 100 * sum(each.rewarded for each in reference) / len(reference)
        yield _rewarded(name, first, reference, reference, "the reference")
        for setup in others:
            source = f"{first.backend}: {share:.0f} %"
            yield _rewarded(name, setup, played[setup][name], reference, source)


def _rewarded(
    name: str, setup: EngineSetup, episodes: Episodes, reference: Episodes, source: str
) -> Quantity:
    hits, share = (sum(each.rewarded for each in group) for group in (episodes, reference))
    same = sum(
        one.predicates == other.predicates for one, other in zip(episodes, reference, strict=True)
    )
    simulated = sum(each.sim_seconds for each in episodes)
    wall = sum(each.wall_seconds for each in episodes)
    note = (
        f"same states in {same}; {simulated / len(episodes):.1f} s simulated, "
        f"{simulated / wall:.1f} times real time{_ending(episodes)}"
    )
    is_reference = episodes is reference
    floor = 100 * share / len(reference) - _WORSE
    expected = None if is_reference else above(floor)
    title = f"{name} on {setup}: rewarded"
    return percentage(title, source, hits, len(episodes), expected, note=note)


def _ending(episodes: Episodes) -> str:
    """The state in which most episodes end that are not rewarded, if there are any."""
    last = Counter(each.predicates[-1] for each in episodes if not each.rewarded)
    if not last:
        return ""
    (state, count), *_ = last.most_common(1)
    return f"; {count} of {last.total()} others end in {state}"
