"""Uses of programs within a program, by the names of the actions that lead to them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import title_of

T = TypeVar("T")


def uses(program: CheckedProgram, use: str = "") -> Iterator[tuple[str, CheckedProgram]]:
    """Yield a program and the programs that it uses, each with the names that lead to it."""
    yield use, program
    used = [(each.part, each.program) for each in program.actions if each.program is not None]
    used += [(f"look for {feature}", look.program) for feature, look in program.looks.items()]
    for name, inner in used:
        yield from uses(inner, f"{use}.{name}" if use else name)


def used_programs(program: CheckedProgram) -> list[CheckedProgram]:
    """Return a program and all programs that it uses, each once."""
    programs: list[CheckedProgram] = []
    for _, each in uses(program):
        programs += [] if each in programs else [each]
    return programs


def by_use(program: CheckedProgram, make: Callable[[CheckedProgram], T | None]) -> dict[str, T]:
    """Return data of a program and of the programs that it uses; see ``of_use``.

    Args:
        program: Program.
        make: Function that returns the data of one program, or ``None`` for no entry.
    """
    made: list[tuple[CheckedProgram, T | None]] = []
    tables: dict[str, dict[str, T | None]] = {}
    for use, each in uses(program):
        if all(each != other for other, _ in made):
            made.append((each, make(each)))
        data = next(data for other, data in made if each == other)
        # Allocations of one action have the same title: the first one stands for all.
        tables.setdefault(each.name, {}).setdefault(title_of(each.name, use), data)
    entries: dict[str, T | None] = {}
    for name, own in tables.items():
        first = next(iter(own.values()))
        # Uses with other arguments may have other members and exits.
        entries |= {name: first} if all(data == first for data in own.values()) else own
    return {key: data for key, data in entries.items() if data is not None}


def of_use(data: Mapping[str, T], program: str, use: str) -> T | None:
    """Return the data of one use of a program, or of its program if all uses are alike.

    Args:
        data: Data by title of the use, or by name of the program.
        program: Name of the program.
        use: Names of the actions that lead to it, parted by dots.
    """
    return data.get(title_of(program, use), data.get(program))
