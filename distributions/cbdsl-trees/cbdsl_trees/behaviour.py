"""Behaviour of py_trees: a program as a leaf of a behaviour tree."""

from __future__ import annotations

from collections.abc import Generator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from cbdsl import EpisodeResult, OpenRobot, Transition
from cbdsl.api.sensing import Tick
from cbdsl.extend.export import automata, of_use, transition_text

#: Status of a behaviour by the predicate of its program.
STATUS = {"X": Status.INVALID, "-": Status.FAILURE, "0": Status.RUNNING, "1": Status.SUCCESS}


class ProgramBehaviour(Behaviour):
    """Program as a behaviour: each tick of the tree is one control tick of the robot.

    Several programs share one body by ``OpenRobot.with_program``, opened with ``persistent=True``:
    each begins in the final state of robot and world of the previous one. They run one at a time: a
    new one interrupts the other. Two in a ``Parallel`` are an error; compose them in one program.

    The feedback message is the last transition, such as ``pick: lift -> carry, since lift is at
    rest``, and after the last tick the ending.

    Args:
        robot: Robot with the program to run.
        name: Name of the behaviour; the program's name if empty.
        seed: Seed of all random draws.

    Attributes:
        result: Outcome of the last complete run; ``None`` before.
    """

    def __init__(self, robot: OpenRobot, name: str = "", *, seed: int = 0) -> None:
        super().__init__(name or robot.request.program.name)
        self._robot, self._seed = robot, seed
        self._automata = automata(robot.request.program, is_short=False)
        self._ticks: Generator[Tick, None, EpisodeResult] | None = None
        self.result: EpisodeResult | None = None

    def initialise(self) -> None:
        """Begin the program from the start."""
        self._leave()
        self._robot.interrupt(
            f"behaviour '{self.name}' has begun, and programs of one robot run one at a time; "
            "to run both at once, compose them in one program, as in 'a ◁ b'"
        )
        self.feedback_message = ""
        self._ticks = self._robot.ticks(self._seed, on_transition=self._note)

    def update(self) -> Status:
        """Run one control tick.

        Raises:
            UsageError: Another behaviour of the same robot has begun since, or the robot is closed.
        """
        assert self._ticks is not None, "the tree begins a behaviour before it updates it"
        try:
            predicate = next(self._ticks).run.predicate
        except StopIteration as ended:
            self._ticks = None
            self.result = ended.value
            # The last tick ends the generator without a value, so that the runner has the final
            # predicate.
            predicate = self._robot.runner().predicate
        if self.result and not self._ticks:
            self.feedback_message = self.result.ending
        # A program is idle (X), has ended without its aim (-), is on its way (0), or at its aim
        # (1).
        return STATUS[predicate]

    def terminate(self, new_status: Status) -> None:
        """Interrupt the program if a behaviour of a higher priority takes over."""
        # py_trees also terminates a behaviour that has succeeded or failed. Only this status
        # interrupts it.
        if new_status is Status.INVALID:
            self._leave()

    def _note(self, transition: Transition) -> None:
        """Note a transition as the feedback message, in words if its action is a step."""
        automaton = of_use(self._automata, transition.program, transition.use)
        words = "" if automaton is None else transition_text(automaton, transition)
        self.feedback_message = f"{transition.title}: {words or transition.action}"

    def _leave(self) -> None:
        if self._ticks is not None:
            self._ticks.close()
            self._ticks = None
