"""Action runner: runs explored actions one after another in a world that goes on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from cbdsl.backends.backend import Backend, BackendError
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.learning.catalogs.action_outcome import NOOP, ActionOutcome
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.episode import EpisodeError, Runner
from cbdsl.runtime.episode_observer import EpisodeObserver, EpisodeObservers
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.feature_reader import FeatureReader
from cbdsl.training.exploration.explorable import Explorable
from cbdsl.types.resource import Resource

Features = Mapping[str, tuple[float, ...]]
"""Components of features that were defined, in SI, by name."""

# Time for which a region must be seen to be accepted, s.
_BELIEVED = 0.3


class ActionRunner:
    """Runner of actions, and of the program between them that brings the robot back.

    The experimenter has one turn before each action, also before ``noop``, and none in between.

    Args:
        robot: Robot that programs were checked against.
        kinematics: Kinematics of the same robot.
        backend: Backend that embodies the robot.
        stage: Stage that describes the world.
        actions: Actions that can be chosen.
        between: Program that runs after each action and makes the robot ready for the next.
        longest: Longest time of an action, s.
        observer: Observer of the episodes.
    """

    def __init__(
        self,
        robot: RobotDocument,
        kinematics: Kinematics,
        backend: Backend,
        stage: StageDocument,
        actions: Sequence[Explorable],
        between: CheckedProgram,
        longest: float,
        observer: EpisodeObserver | None = None,
    ) -> None:
        self._robot, self._kinematics = robot, kinematics
        self._backend, self._stage = backend, stage
        self._actions = {each.name: each for each in actions}
        self._between, self._longest = between, longest
        self._observer = observer or EpisodeObserver()
        self._runners: dict[tuple[str, tuple[str, ...]], Runner] = {}
        self._last: Runner | None = None
        self._turns = 0

    def known(self, names: Sequence[str]) -> dict[str, Explorable]:
        """Return the actions with these names, including the marks of other actions."""
        marks = [mark for each in self._actions.values() for mark in each.marks.values()]
        everything = {**self._actions, **{mark.name: mark for mark in marks}}
        return {name: everything[name] for name in names if name in everything}

    def run(
        self, name: str, known: Sequence[str], seed: int, *, undisturbed: bool = False
    ) -> ActionOutcome:
        """Carry out an action.

        Args:
            name: Name of the action.
            known: Names of all actions whose features are read after the action.
            seed: Seed of all its random numbers.
            undisturbed: True if the experimenter leaves out the turn before it.

        An error ends the action and is reported in its outcome. The next action then begins in a
        world that is set up again.
        """
        try:
            outcome = self._act(name, known, seed, undisturbed)
            # The turn of the experimenter is before the action. Before noop, which runs no episode,
            # it is before the return of the robot.
            ahead, seconds = self._come_back(known, seed, undisturbed=name != NOOP)
        except (EpisodeError, BackendError) as error:
            self._last = None
            return ActionOutcome(name, ending=str(error), failed=name != NOOP)
        return replace(outcome, ahead=ahead, sim_seconds=outcome.sim_seconds + seconds)

    def replay(self, name: str) -> None:
        """Count an action of an earlier process, so that marks take turns as if it had gone on."""
        action = self.known([name]).get(name)
        if action is not None and action.marks:
            self._turns += 1

    def look(self, known: Sequence[str], seed: int) -> dict[str, Features]:
        """Set the world up again, bring the robot back, and read the features of each action.

        Raises:
            EpisodeError, BackendError: If the robot cannot do this.
        """
        self._last = None
        return self._come_back(known, seed, undisturbed=False)[0]

    def _act(self, name: str, known: Sequence[str], seed: int, undisturbed: bool) -> ActionOutcome:
        if name == NOOP:
            return ActionOutcome(NOOP)
        action = self.known([name])[name]
        if action.marks:
            return self._inspect(action, known, seed, undisturbed)
        reader = FeatureReader(action.features)
        return _outcome(name, self._episode(action, reader, seed, undisturbed), reader)

    def _inspect(
        self, action: Explorable, known: Sequence[str], seed: int, undisturbed: bool
    ) -> ActionOutcome:
        """Run an action that searches for a mark of one of several channels.

        The outcome counts once, for the chosen action and with the features of that action, whether
        rewarded or not. Visible marks become actions, which count from when they are chosen.
        """
        open_marks = [m for m, each in action.marks.items() if each.name not in known]
        if not open_marks:
            open_marks = list(action.marks)
        # The marks take turns; those without a catalog entry have precedence.
        mark = open_marks[self._turns % len(open_marks)]
        self._turns += 1
        own = action.marks[mark]
        reader = FeatureReader(action.features, {m: e.presence for m, e in action.marks.items()})
        result = self._episode(own, reader, seed, undisturbed, [*own.observed, *action.observed])
        seen = {m for m, seconds in reader.seconds.items() if seconds >= _BELIEVED}
        new = tuple(each.name for m, each in action.marks.items() if m in seen)
        outcome = _outcome(action.name, result, reader)
        return replace(outcome, opened=new, rewarded=outcome.rewarded and mark in seen)

    def _episode(
        self,
        action: Explorable,
        reader: FeatureReader,
        seed: int,
        undisturbed: bool,
        observed: Sequence[Resource] = (),
    ) -> EpisodeResult:
        runner = self._runner(action.name, action.program, observed or action.observed)
        return self._run(runner, seed, reader, undisturbed=undisturbed)

    def _come_back(
        self, known: Sequence[str], seed: int, *, undisturbed: bool
    ) -> tuple[dict[str, Features], float]:
        """Make the robot ready, and read the features of each action."""
        observed = [each for action in self._actions.values() for each in action.observed]
        runner = self._runner("", self._between, observed)
        result = self._run(runner, seed, None, undisturbed=undisturbed)
        ahead: dict[str, Features] = {}
        for name, action in self.known(known).items():
            if runner.signals.read(action.presence) is None:
                continue
            own = {key: _value(runner, each) for key, each in action.features.items()}
            ahead[name] = {"seen": (), **{k: v for k, v in own.items() if v is not None}}
        return ahead, result.sim_seconds

    def _runner(self, name: str, program: CheckedProgram, observed: Sequence[Resource]) -> Runner:
        # An action that was found as a mark runs for itself, too, and then observes other signals.
        key = name, tuple(each.name for each in observed)
        if key not in self._runners:
            program = program._replace(
                episode_time=min(self._longest, program.episode_time or self._longest)
            )
            self._runners[key] = Runner(
                self._robot, self._kinematics, program, self._backend, observed=observed
            )
        return self._runners[key]

    def _run(
        self, runner: Runner, seed: int, reader: FeatureReader | None, *, undisturbed: bool
    ) -> EpisodeResult:
        if self._last is not None:
            runner.take_over(self._last)
        observer = self._observer
        if reader is not None:
            observer = EpisodeObservers(reader, observer)
        result = runner.run(self._stage, seed, observer=observer, undisturbed=undisturbed)
        self._last = runner
        return result


def _value(runner: Runner, resource: Resource) -> tuple[float, ...] | None:
    """Return the current value of a signal; ``None`` for a sample."""
    if resource.name not in {each.name for each in runner.observed}:
        return None
    reading = runner.signals.read(resource)
    return None if reading is None else tuple(reading.value.ravel().tolist())


def _outcome(name: str, result: EpisodeResult, reader: FeatureReader) -> ActionOutcome:
    return ActionOutcome(
        name,
        rewarded=result.rewarded,
        features=dict(reader.values),
        ending=result.ending,
        sim_seconds=result.sim_seconds,
    )
