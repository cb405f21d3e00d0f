"""Breakpoints of a watched run: steps and exits at which it pauses."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from cbdsl.checking.rules.flow import automaton_of
from cbdsl.diagnostics.nearest import suggestion
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.runtime.program_run import ProgramRun

_END = {"success": "succeed", "failure": "fail"}


# A place is a step, such as ``lift`` or ``grip.close`` for a step of a used program, or an exit,
# such as ``lift -> carry``. The target of an exit is known once the program has chosen, after its
# transition. A used program that ends is left within the same tick, so that its outcome is read
# before the next transition.
class Breakpoints:
    """Steps and exits at which a run pauses, before the references of that tick are applied.

    Attributes:
        places: Steps and exits of the program.
        chosen: Places at which the run pauses.
        met: Place at which it pauses in this tick; empty for none.
    """

    def __init__(self) -> None:
        self.places: tuple[str, ...] = ()
        self.chosen: frozenset[str] = frozenset()
        self.met, self._waits_for_change = "", False
        self._steps: tuple[str, ...] = ()
        self._left: list[Transition] = []
        self._passed: list[str] = []

    @property
    def shown(self) -> tuple[list[str], str]:
        """Chosen places, and the place of the current pause."""
        return sorted(self.chosen), self.met

    def begin(self) -> None:
        """Begin an episode."""
        self.met, self._steps, self._left, self._passed = "", (), [], []

    def follow(self, program: CheckedProgram) -> None:
        """List the places of a program, or of its edited version."""
        self.places = tuple(dict.fromkeys(_places(program, "")))

    def choose(self, places: Collection[str]) -> None:
        """Pause at these places from now on; a place that an edit has removed may stay.

        Raises:
            ValueError: The program has no such place.
        """
        for place in places:
            if place not in self.places and place not in self.chosen:
                near = suggestion(place, self.places)
                raise ValueError(f"the program has no step or exit '{place}'{near}")
        self.chosen = frozenset(places)

    def wait_for_change(self) -> None:
        """Pause once at the next change of state of any program."""
        self._waits_for_change = True

    def note_transition(self, transition: Transition, run: ProgramRun | None) -> None:
        """Note a transition of a run that has begun its ticks."""
        self._read(run)
        self._left.append(transition)

    def reach(self, run: ProgramRun) -> bool:
        """Return whether the run pauses in this tick, and store the place."""
        self._read(run)
        before, self._steps = self._steps, tuple(_steps(run))
        entered = [each for each in self._steps if each not in before]
        passed, self._passed = [*self._passed, *entered], []
        reached = [each for each in passed if each in self.chosen]
        if self._waits_for_change and passed:
            reached += passed[:1]
            self._waits_for_change = False
        self.met = reached[0] if reached else ""
        return bool(reached)

    def _read(self, run: ProgramRun | None) -> None:
        """Note the exits and steps of transitions whose targets have been chosen."""
        for left in self._left if run is not None else ():
            at = run
            for part in left.use.split(".") if left.use else ():
                at = None if at is None else _used(at, part)
            if at is None:
                continue
            within, target = f"{left.use}." if left.use else "", _target(at)
            self._passed.append(f"{within}{_step(at.program, left.action)} -> {target}")
            if at.predicate == "0":
                self._passed.append(f"{within}{target}")
        self._left = []


def _used(run: ProgramRun, part: str) -> ProgramRun | None:
    """Return the run of a program that is used as a part of the running action."""
    action = run.action
    return run.children.get(action.name if action and action.part == part else part)


def _target(run: ProgramRun) -> str:
    if run.predicate != "0":
        return _END.get(run.outcome, "end")
    return "" if run.action is None else _step(run.program, run.action.name)


def _step(program: CheckedProgram, action: str) -> str:
    return program.steps.get(action, action)


def _steps(run: ProgramRun, within: str = "") -> Iterator[str]:
    """Yield the step that runs, followed by those of the programs that it uses."""
    if run.action is None:
        return
    yield within + _step(run.program, run.action.name)
    child = run.children.get(run.action.name)
    if child is not None and child.predicate == "0":
        yield from _steps(child, f"{within}{run.action.part}.")


def _places(program: CheckedProgram, within: str) -> Iterator[str]:
    """Yield the steps of a program, each followed by its exits and the steps that it uses."""
    automaton = automaton_of(program)
    targets = None if automaton is None or program.schema else automaton.targets()
    for action in program.actions:
        if targets is not None and action.name not in targets:
            continue  # the policy never chooses it
        step = within + _step(program, action.name)
        yield step
        for to in () if targets is None else targets[action.name]:
            if to.step != action.name:
                yield f"{step} -> {_step(program, to.step) or _END.get(to.end, to.end)}"
        if action.program is not None:
            yield from _places(action.program, f"{within}{action.part}.")
