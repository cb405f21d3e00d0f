"""Trials of impedance: a pair of things brought together by a hand, and felt in twelve tests."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple, Self

from cbdsl.backends.simulated_backend import simulate
from cbdsl.checking.knowledge.digest import program_digest
from cbdsl.checking.program import check_program
from cbdsl.documents.digest import digest_of_text
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.learning.impedance import ImpedanceProfile
from cbdsl.reproduction.shipped import shipped_file, shipped_robot
from cbdsl.reproduction.thing_pairs import ALL_PAIRS
from cbdsl.runtime.episode import Runner
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.training.impedance_gauge import ImpedanceGauge
from cbdsl.yaml_text.library import Library, shipped

PROGRAM = "impedance"


class ImpedanceTrial(NamedTuple):
    """One episode.

    Attributes:
        things: name of the pair.
        seed: of the episode.
        profile: what was felt; not whole where the things did not come together.
        ending: of the program.
        sim_seconds: simulated.
    """

    things: str
    seed: int
    profile: ImpedanceProfile
    ending: str
    sim_seconds: float

    def as_data(self) -> dict[str, Any]:
        """Plain data, for JSON."""
        return {**self._asdict(), "profile": self.profile.as_data()}

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Self:
        """Trial that ``as_data`` wrote.

        Raises:
            ValueError: it is no trial, or a test of its profile is none.
        """
        if set(data) != set(cls._fields):
            raise ValueError(f"no trial of impedance: it has {', '.join(sorted(data))}")
        return cls(**{**data, "profile": ImpedanceProfile.from_data(data["profile"])})


def trial_digest(name: str) -> str:
    """Digest of all that decides trials of a pair beside seed and engine."""
    library, pair = Library(shipped()), ALL_PAIRS[name]
    file = shipped_file(library, ProgramDocument, PROGRAM)
    robot, _ = shipped_robot(library.read(file, ProgramDocument).document.robot, library)
    stage = library.read(shipped_file(library, StageDocument, pair.stage), StageDocument).document
    parts = (
        str(program_digest(file, library)),
        # Its policy is no part of that.
        file.read_text(encoding="utf-8"),
        str(sorted(pair.values.items())),
        robot.model_dump_json(),
        stage.model_dump_json(),
    )
    return digest_of_text("\n".join(parts))


def run_trials(
    name: str, seeds: Iterable[int], engine: str, cameras: str | None
) -> Iterator[ImpedanceTrial]:
    """Feel one pair, once for each seed.

    Raises:
        BackendError, EpisodeError: the simulator cannot run it.
        ImportError: it is not installed.
    """
    library, pair = Library(shipped()), ALL_PAIRS[name]
    file = shipped_file(library, ProgramDocument, PROGRAM)
    program = check_program(file, pair.values, library)
    stage = library.read(shipped_file(library, StageDocument, pair.stage), StageDocument).document
    robot, urdf = shipped_robot(program.robot, library)
    backend = simulate(engine, robot, urdf, cameras=cameras)
    try:
        runner = Runner(robot, Kinematics(robot, urdf), program, backend)
        for seed in seeds:
            gauge = ImpedanceGauge(program)
            result = runner.run(stage, seed, name, on_tick=gauge.note)
            profile = gauge.finish(runner.signals)
            yield ImpedanceTrial(name, seed, profile, result.ending, result.sim_seconds)
    finally:
        backend.close()
