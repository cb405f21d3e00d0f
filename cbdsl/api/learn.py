"""``cbdsl.learn``: a policy from episodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.run_request import RunRequest
    from cbdsl.learning.experience import Experience
    from cbdsl.training.learning_task import LearningTask


@dataclass(frozen=True)
class LearningOutcome:
    """Knowledge from one trial.

    Attributes:
        policy: File of the policy, for ``load(..., policy=...)``.
        files: All written documents, of the policy and of internal models.
        episodes: Experience of each episode, in order.
    """

    policy: Path
    files: tuple[Path, ...]
    episodes: tuple[Experience, ...]

    @property
    def rewarded(self) -> tuple[bool, ...]:
        """True for each rewarded episode, in order."""
        return tuple(any(each.reward for each in one.transitions) for one in self.episodes)


def learn(
    program: str | Path | RunRequest,
    out: str | Path,
    *,
    episodes: int = 50,
    seed: int = 0,
    backend: str | None = None,
    cameras: str | None = None,
    learner: str = "accommodate",
    constants: Mapping[str, str | float] | None = None,
    resume: bool = False,
    on_episode: Callable[[Experience], None] | None = None,
) -> LearningOutcome:
    """Learn a policy for a program from scratch, in this process.

    A file beside the policy's holds each episode as soon as it is over. With ``resume`` an
    interrupted trial continues, with the same result as without an interruption.

    Args:
        program: Result of ``load``, or a file or name for it.
        out: File for the policy, ``NAME.yaml``; internal models are written beside it.
        episodes: Total number of episodes.
        seed: Seed of all random draws.
        backend: Name of the backend, as for ``open_robot``.
        cameras: Kind of cameras, as for ``open_robot``.
        learner: Name of the algorithm.
        constants: Constants of the algorithm, by name, in SI or as text with units.
        resume: True to continue a trial that was begun there.
        on_episode: Function called with each new episode, not with those of a resumed trial.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed or unsuitable, or a file is in the way.
        OSError: A document cannot be written.
    """
    from cbdsl.api.load import load
    from cbdsl.api.open_robot import open_robot
    from cbdsl.api.run_request import RunRequest
    from cbdsl.backends.engines import default_engine

    backend = default_engine() if backend is None else backend
    request = program if isinstance(program, RunRequest) else load(program)
    task = _task(request, Path(out), episodes, seed, backend, cameras, learner, constants or {})
    task.require_ready(resume=resume)
    watcher = _Watcher(on_episode)
    with open_robot(request, backend=backend, cameras=cameras) as robot:
        files = task.run(robot.backend, robot.kinematics, watcher)
    return LearningOutcome(task.path, tuple(files), tuple(watcher.episodes))


class _Watcher:
    """Observer of one trial that keeps its episodes."""

    def __init__(self, on_episode: Callable[[Experience], None] | None) -> None:
        self.episodes: list[Experience] = []
        self._tell = on_episode

    def begin(self, number: int, renderer: str, finished: Sequence[Experience]) -> None:
        """Begin with the finished episodes; see ``TrialObserver.begin``."""
        self.episodes.extend(finished)

    def note(self, number: int, experience: Experience, seconds: float) -> None:
        """Note an episode; see ``TrialObserver.note``."""
        self.episodes.append(experience)
        if self._tell is not None:
            self._tell(experience)


def _task(
    request: RunRequest,
    out: Path,
    episodes: int,
    seed: int,
    backend: str,
    cameras: str | None,
    learner: str,
    constants: Mapping[str, str | float],
) -> LearningTask:
    """Return the trial, as ``cb learn`` would describe it."""
    from cbdsl.checking.knowledge.digest import program_digest
    from cbdsl.errors.errors import UsageError
    from cbdsl.learning.constants import read_constants
    from cbdsl.learning.learner import ASSIMILATE, LEARNERS
    from cbdsl.training.learning_task import LearningTask

    if learner == ASSIMILATE:
        raise UsageError("assimilate learns the resources of a policy: cb learn --from does that")
    given = {name: str(value) for name, value in constants.items()}
    options = [("episodes", episodes), ("seed", seed), ("backend", backend), ("learner", learner)]
    words = [f"{name}={value!r}" for name, value in [*options, ("constants", given)]]
    chosen = (request.program.name, request.stage.name, dict(request.program.parameters))
    loaded = "cbdsl.load({!r}, stage={!r}, values={!r})".format(*chosen)
    return LearningTask(
        program=request.program,
        digest=program_digest(request.program_file, request.library),
        robot=request.robot,
        urdf=request.urdf.absolute(),
        stage=request.stage,
        backend=backend,
        learner=learner,
        constants=read_constants(LEARNERS.get(learner).Constants, given, learner),
        seed=seed,
        number=0,
        episodes=episodes,
        command=f"cbdsl.learn({loaded}, {out.name!r}, {', '.join(words)})",
        path=out.absolute(),
        cameras=cameras,
    )
