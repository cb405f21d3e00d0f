"""Child runs: programs that run inside another program, as its actions or searches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.action_levels import Active


class ChildRun(Protocol):
    """Run of a program inside another one; see ``ProgramRun``."""

    predicate: str
    rewarded: bool

    def activate(self) -> None: ...
    def advance(self) -> None: ...
    def deactivate(self) -> None: ...
    def active(self) -> Sequence[Active]: ...


Run = TypeVar("Run")


def subprogram_runs(
    program: CheckedProgram, make: Callable[[CheckedProgram, str], Run]
) -> dict[str, Run]:
    """Return the runs of subprograms by action, one for each member and allocation.

    Args:
        program: Program with the actions.
        make: Function of a subprogram and the name of its member that returns a run.
    """
    made: dict[tuple[str, str], Run] = {}
    runs = {}
    for action in program.actions:
        if action.program is None:
            continue
        key = action.part, action.allocation
        if key not in made:
            made[key] = make(action.program, action.part)
        runs[action.name] = made[key]
    return runs
