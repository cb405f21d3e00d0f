"""Action runner: carries out explored actions one after another in a world that goes on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cbdsl.backends.backend import Backend, BackendError
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.learning.action_outcome import NOOP, ActionOutcome
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.episode import EpisodeError, EpisodeResult, Runner, Tick
from cbdsl.runtime.episode_watcher import EpisodeWatcher
from cbdsl.runtime.feature_reader import FeatureReader
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.training.explorable import Explorable
from cbdsl.types.resource import Resource

Features = Mapping[str, tuple[float, ...]]
"""Components of features that were defined, in SI, by name."""

# A region that is seen for so long is one, s.
_BELIEVED = 0.3


class ActionRunner:
    """Runs actions, and between them the program that brings the robot back.

    The experimenter has one turn before each action, ``noop`` too, and none in between.

    Args:
        robot: the robot that programs were checked against.
        kinematics: of the same robot.
        backend: its body.
        stage: the world.
        actions: what can be done.
        between: what the robot does after each of them, which makes it ready for the next.
        longest: time of an action, s.
        watcher: is told everything of the episodes, if there is one.
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
        watcher: EpisodeWatcher | None = None,
    ) -> None:
        self._robot, self._kinematics = robot, kinematics
        self._backend, self._stage = backend, stage
        self._actions = {each.name: each for each in actions}
        self._between, self._longest, self._watcher = between, longest, watcher
        self._runners: dict[str, Runner] = {}
        self._last: Runner | None = None
        self._turns = 0

    def known(self, names: Sequence[str]) -> dict[str, Explorable]:
        """Actions by name, those among them that others turn out to be."""
        marks = [mark for each in self._actions.values() for mark in each.marks.values()]
        everything = {**self._actions, **{mark.name: mark for mark in marks}}
        return {name: everything[name] for name in names if name in everything}

    def run(
        self, name: str, known: Sequence[str], seed: int, *, undisturbed: bool = False
    ) -> ActionOutcome:
        """Carry out an action.

        Args:
            name: of the action.
            known: names of all actions, whose features are looked at when it is over.
            seed: of all chance in it.
            undisturbed: whether the experimenter leaves out the turn before it.

        Whatever stops the action, its outcome says so: the next one begins in a world that is set
        up anew.
        """
        try:
            outcome = self._act(name, known, seed, undisturbed)
            ahead, seconds = self._come_back(known, seed, undisturbed=name != NOOP)
        except (EpisodeError, BackendError) as error:
            self._last = None
            return ActionOutcome(name, ending=str(error), failed=name != NOOP)
        return outcome._replace(ahead=ahead, sim_seconds=outcome.sim_seconds + seconds)

    def look(self, known: Sequence[str], seed: int) -> dict[str, Features]:
        """Set the world up anew, bring the robot back, and look at what each action would find.

        Raises:
            EpisodeError, BackendError: it cannot.
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
        result = self._episode(action, reader, seed, undisturbed)
        return _outcome(name, result, reader)

    def _inspect(
        self, action: Explorable, known: Sequence[str], seed: int, undisturbed: bool
    ) -> ActionOutcome:
        """Run an action that looks for a mark of one of several channels.

        Rewarded or not, it counts as the action that was chosen. The marks that it shows become
        actions, which count from when they are chosen themselves.
        """
        open_marks = [m for m, each in action.marks.items() if each.name not in known]
        if not open_marks:
            open_marks = list(action.marks)
        mark = open_marks[self._turns % len(open_marks)]
        self._turns += 1
        own = action.marks[mark]
        reader = FeatureReader(own.features, {m: e.presence for m, e in action.marks.items()})
        result = self._episode(own, reader, seed, undisturbed, [*own.observed, *action.observed])
        seen = {m for m, seconds in reader.seconds.items() if seconds >= _BELIEVED}
        new = tuple(each.name for m, each in action.marks.items() if m in seen)
        outcome = _outcome(action.name, result, reader)
        return outcome._replace(opened=new, rewarded=outcome.rewarded and mark in seen)

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
        """Make the robot ready, and look at what each action would find."""
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
        if name not in self._runners:
            program = program._replace(
                episode_time=min(self._longest, program.episode_time or self._longest)
            )
            self._runners[name] = Runner(
                self._robot, self._kinematics, program, self._backend, observed=observed
            )
        return self._runners[name]

    def _run(
        self, runner: Runner, seed: int, reader: FeatureReader | None, *, undisturbed: bool
    ) -> EpisodeResult:
        if self._last is not None:
            runner.take_over(self._last)
        result = self._watched(runner, seed, reader, undisturbed=undisturbed)
        self._last = runner
        return result

    def _watched(
        self, runner: Runner, seed: int, reader: FeatureReader | None, *, undisturbed: bool
    ) -> EpisodeResult:
        """Run an episode, of which reader and watcher are told."""
        stage, watcher = self._stage, self._watcher
        note_tick = None if reader is None else reader.note_tick
        if watcher is None:
            return runner.run(stage, seed, on_tick=note_tick, undisturbed=undisturbed)
        watched = watcher

        def on_tick(tick: Tick) -> None:
            if note_tick is not None:
                note_tick(tick)
            watched.note_tick(tick)

        watcher.begin(runner.program, stage.name, seed)
        return runner.run(
            stage,
            seed,
            on_transition=watcher.note_transition,
            on_tick=on_tick,
            on_end=watcher.note_end,
            undisturbed=undisturbed,
        )


def _value(runner: Runner, resource: Resource) -> tuple[float, ...] | None:
    """Value of a signal now; a draw has none."""
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
