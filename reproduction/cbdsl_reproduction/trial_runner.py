"""Series of trials on one backend, and greedy episodes under the learned policies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cbdsl import RunRequest, Transition
from cbdsl.api.control import Kinematics
from cbdsl.api.documents import (
    CatalogDocument,
    Provenance,
    RobotDocument,
    StageDocument,
    write_text,
)
from cbdsl.api.learning import AccommodateConstants, Experience
from cbdsl.api.program import CheckedProgram, Policy, WrittenPolicy
from cbdsl.api.shipped import shipped_program, shipped_robot
from cbdsl.api.trials import (
    EPISODES,
    Backend,
    BackendEpisodeRunner,
    FinishedAction,
    ItemListener,
    Journal,
    TaskObserver,
    Trial,
    TrialSetting,
    embody,
    exploration_journal,
    identity_of,
    open_journal,
    provenance_of,
    run_trial,
)
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.exploration_series import ExplorationSeries
from cbdsl_reproduction.handedness_series import HandednessSeries
from cbdsl_reproduction.series import Series

_ROBOT = "dexter"
# As many seeds as is customary in the field if the backend is fast, else as many as in the source.
_TRIALS = {"kinematic": 30}
_QUICK_TRIALS, _QUICK_EPISODES = 2, 6
# First number of the held-out episodes of a trial, far beyond the numbers of its own episodes.
_HELD_OUT = 1_000_000


@dataclass(frozen=True)
class LearnedTrial:
    """Trial at its end, or after some of its episodes.

    Attributes:
        trial: Learner and its episodes.
        provenance: Provenance of the whole trial.
        stage: Training stage.
        path: Path of the policy; results about it are stored beside it.
    """

    trial: Trial
    provenance: Provenance
    stage: StageDocument
    path: Path

    def after(self, episodes: int) -> LearnedTrial:
        """Return the same trial after its first ``episodes``."""
        whole = self.trial
        trial = Trial(whole.program, whole.constants, whole.seed, whole.number)
        for experience in whole.experiences[:episodes]:
            trial.replay(experience)
        return LearnedTrial(trial, self.provenance, self.stage, self.path)

    def held_out(self, count: int) -> list[int]:
        """Return seeds of episodes that the trial does not learn from."""
        entropy = (
            np.random.SeedSequence([self.trial.seed, self.trial.number, _HELD_OUT + index])
            for index in range(count)
        )
        return [int(each.generate_state(1)[0]) for each in entropy]


class TrialRunner(TaskObserver[Experience]):
    """Runner of consecutive episodes that skips the stored ones.

    Args:
        settings: Seed, number of trials, folder and progress callback.
        body: Backend that runs the episodes.
        robot: Robot that the backend embodies.
        kinematics: Kinematics of the same robot.
        observer: Observer that is notified of each episode that is run, and may stop the run.

    Attributes:
        robot: Embodied robot.
    """

    def __init__(
        self,
        settings: RunSettings,
        body: Backend,
        robot: RobotDocument,
        kinematics: Kinematics,
        observer: TaskObserver[Experience] | None = None,
    ) -> None:
        self._settings = settings
        self._body, self.robot, self._kinematics = body, robot, kinematics
        self._observer = observer or TaskObserver()
        self._done = self._expected = 0

    @property
    def renderer(self) -> str:
        """Name of the renderer of the images."""
        return self._body.renderer

    def expect(self, episodes: int) -> None:
        """Add a number of episodes to the expected total."""
        self._expected += episodes

    def numbers(self, series: Series | ExplorationSeries | HandednessSeries) -> list[int]:
        """Return the numbers of the trials of a series to run."""
        numbers = range(trials(self._settings, series))
        return [each for each in numbers if self._settings.only in (None, each)]

    def episodes(self, series: Series | HandednessSeries) -> int:
        """Return the number of episodes of each trial."""
        return _QUICK_EPISODES if self._settings.quick else series.episodes

    def learn(self, series: Series) -> list[LearnedTrial]:
        """Run the trials of a series, each from zero.

        Raises:
            JournalError: The folder holds other trials.
            BackendError, EpisodeError: The simulator cannot run them.
            OSError: They cannot be stored.
        """
        program = self.program(series)
        return [self._follow(series, program, n) for n in self.numbers(series)]

    def explore(self, series: ExplorationSeries) -> list[CatalogDocument]:
        """Run the explorations of a series, each from zero.

        Raises:
            JournalError: The folder holds other explorations.
            OSError: They cannot be stored.
        """
        return [self._explore(series, number) for number in self.numbers(series)]

    def actions(self, series: ExplorationSeries) -> int:
        """Return the number of actions of each exploration, including the one it is grown from."""
        before = 0 if series.grown_from is None else self.actions(series.grown_from)
        return before + (_QUICK_EPISODES if self._settings.quick else series.actions)

    def _explore(self, series: ExplorationSeries, number: int) -> CatalogDocument:
        settings, count, done = self._settings, self.actions(series), 0
        where, before = (settings.backend, settings.cameras), self._grow(series, number)
        request = replace(
            series.request(self.path(series, number)),
            backend=settings.backend,
            cameras=settings.cameras,
            seed=settings.seed,
            number=number,
            actions=count,
            command=series.command(settings.seed, count, *where),
        )
        _, task = request.task()

        def note(action: FinishedAction) -> None:
            nonlocal done
            done += 1
            outcome = action.outcome
            seconds = outcome.sim_seconds, outcome.wall_seconds
            self.note(number, Experience(series.stage, number, (), {}, 0, *seconds))

        catalog = task.run(self._body, self._kinematics, ItemListener(note))
        self._advance(count - before - done)
        return catalog

    def _grow(self, series: ExplorationSeries, number: int) -> int:
        """Run the exploration that a series is grown from, and return its number of actions."""
        known = series.grown_from
        if known is None:
            return 0
        self._explore(known, number)
        count = self.actions(known)
        begun = exploration_journal(self.path(series, number))
        if not begun.exists():
            rows = exploration_journal(self.path(known, number)).read_text(encoding="utf-8")
            # Its first line describes the exploration.
            write_text("".join(rows.splitlines(keepends=True)[: 1 + count]), begun)
        return count

    def program(self, series: Series) -> CheckedProgram:
        """Return the program of a series, with the actions to choose from."""
        program = self._request(series).program
        return program._replace(actions=series.actions(program))

    def _request(self, series: Series) -> RunRequest:
        """Return the program of a series on its stage."""
        return shipped_program(series.program, stage=series.stage)

    def greedy(
        self,
        learned: LearnedTrial,
        name: str,
        seeds: Sequence[int],
        program: CheckedProgram | None = None,
        known: Sequence[Experience] = (),
    ) -> tuple[Experience, ...]:
        """Run episodes under the greedy policy, without exploration or learning.

        Args:
            learned: Trial whose policy chooses the actions.
            name: Name of these episodes, for their file beside the policy.
            seeds: Seed of each episode.
            program: Program with internal models that replace the learned ones.
            known: Episodes of the same program under other policies; an episode in which this
                policy would choose the same actions is reused.

        Raises:
            JournalError, BackendError, EpisodeError, OSError: As ``learn``.
        """
        trial = learned.trial
        actions = trial.learner.greedy()
        policy = WrittenPolicy(actions)
        # An episode is determined by its program, its seed and its actions.
        same = {each.seed: each for each in known if _chooses(policy, each)}
        program = trial.informed_program() if program is None else program
        episode_runner = self.episode_runner(learned.stage)
        path = learned.path.with_suffix(f".{name}.jsonl")
        identity = identity_of(learned.provenance) | {"policy": actions}
        with Journal(path, identity, EPISODES) as journal:
            experiences = list(journal.rows[: len(seeds)])
            self._advance(len(experiences))
            for seed in seeds[len(experiences) :]:
                experiences.append(
                    same.get(seed) or episode_runner.run(program, policy, seed, _ignore)
                )
                journal.append(experiences[-1])
                self.note(trial.number, experiences[-1])
        return tuple(experiences)

    def begin(self, number: int, renderer: str, finished: Sequence[Experience]) -> None:
        """Count the stored episodes; see ``TaskObserver.begin``."""
        self._advance(len(finished))

    def note(self, number: int, item: Experience) -> None:
        """Count an episode and notify the observer; see ``TaskObserver.note``."""
        self._advance(1)
        self._observer.note(number, item)

    def _follow(self, series: Series, program: CheckedProgram, number: int) -> LearnedTrial:
        """Run one trial from its beginning, or from the point of its interruption."""
        settings, episodes = self._settings, self.episodes(series)
        request = self._request(series)
        stage = request.stage
        setting = TrialSetting(
            digest=request.digest,
            robot=self.robot,
            stage=stage,
            backend=settings.backend,
            renderer=self._body.renderer,
        )
        constants = AccommodateConstants(density=series.density)
        trial = Trial(program, constants, settings.seed, number)
        count = trials(settings, series)
        where = settings.backend, settings.cameras
        command = series.command(settings.seed, count, episodes, *where)
        provenance = provenance_of(trial, setting, episodes, command)
        path = self.path(series, number)
        with open_journal(path, provenance) as journal:
            run_trial(trial, self.episode_runner(stage), journal, provenance, path, self)
        return LearnedTrial(trial, provenance, stage, path)

    def episode_runner(self, stage: StageDocument) -> BackendEpisodeRunner:
        """Return a runner of episodes of a stage."""
        return BackendEpisodeRunner(self.robot, self._kinematics, self._body, stage)

    def path(self, series: Series | ExplorationSeries | HandednessSeries, number: int) -> Path:
        """Return the path of a policy; trials that are not comparable have separate folders."""
        settings = self._settings
        eyes = "" if settings.cameras is None else f"_{settings.cameras}"
        folder = settings.folder / f"{settings.backend}{eyes}_{settings.seed}" / series.name
        folder.mkdir(parents=True, exist_ok=True)
        return folder / f"{series.name}_{number}.yaml"

    def _advance(self, episodes: int) -> None:
        self._done += episodes
        self._settings.progress(self._done, max(self._expected, self._done))


def trials(settings: RunSettings, series: Series | ExplorationSeries | HandednessSeries) -> int:
    """Return the number of trials of a series."""
    if settings.trials is not None:
        return settings.trials
    return _QUICK_TRIALS if settings.quick else _TRIALS.get(settings.backend, series.trials)


def shipped_dexter() -> tuple[RobotDocument, Path]:
    """Return the robot of all series, and its URDF."""
    return shipped_robot(_ROBOT)


@contextmanager
def trial_runner(settings: RunSettings) -> Iterator[TrialRunner]:
    """Provide a runner on the backend of the settings.

    Raises:
        BackendError: The backend does not exist, or cannot embody the robot.
    """
    robot, urdf = shipped_dexter()
    body = embody(settings.backend, robot, urdf, cameras=settings.cameras)
    try:
        yield TrialRunner(settings, body, robot, Kinematics(robot, urdf))
    finally:
        body.close()


def _chooses(policy: Policy, experience: Experience) -> bool:
    """Return whether an episode with the same seed is identical under a policy."""
    return all(
        policy.choose(each.state, changed=True).action == each.action
        for each in experience.transitions
    )


def _ignore(transition: Transition) -> None:
    """Ignore a transition: nothing is learned from greedy episodes."""
