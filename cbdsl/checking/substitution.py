"""Substitution: whole programs in the place of one with the same reward (Section 5.3.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.correspondence import affordances, correspondence, in_place_of
from cbdsl.types.allotment import PROGRAM, WHOLE, allotment
from cbdsl.types.role import ROBOT

Examine = Callable[[Path, Mapping[str, str], Diagnostics], Outcome[CheckedProgram]]
"""Check of a program with values of its parameters, which adds to the given diagnostics."""


class Allocation(NamedTuple):
    """One choice of resources for the exchangeable parameters of a program.

    Attributes:
        values: Resource or channel by parameter; another program by ``program``.
        choices: Value of the first parameter of each group, by the group's name.
        program: Program with these values, or ``None`` if they do not fit.
        refusal: Reason why they do not fit; empty if they do.
    """

    values: Mapping[str, str]
    choices: Mapping[str, str]
    program: CheckedProgram | None
    refusal: str


def substitutes(
    path: Path, values: Mapping[str, str], session: Session, examine: Examine
) -> Iterator[Allocation]:
    """Yield the programs with the reward that a program requires of its substitutes.

    Args:
        path: File of a program without diagnostics.
        values: Values of its parameters; other programs take over the values of common parameters.
        session: Session with the documents read so far.
        examine: Check of a program with values of its parameters.
    """
    library = session.library
    document = library.read(path, ProgramDocument).document
    wanted = _wanted(document)
    if not wanted:
        return
    program = examine(path, values, Diagnostics())
    if isinstance(program, Unknown):
        return
    document = library.read(path, ProgramDocument).document  # on the robot of the program
    for name in library.names(ProgramDocument, path):
        file = library.find(ProgramDocument, name, path)
        if file is None or library.real(file) == library.real(path):
            continue
        other = examined(file, document, values, session, examine)
        if not isinstance(other, Unknown) and affordances(other) & wanted:
            yield _substitute(program, other)


def stand_in(
    name: str, path: Path, values: Mapping[str, str], session: Session, examine: Examine
) -> tuple[CheckedProgram | None, str]:
    """Return a program in the place of another, or ``None`` with the reason against it.

    Args:
        name: Name of the program that stands in.
        path: File of the replaced program, without diagnostics.
        values: Values of the parameters of both programs.
        session: Session with the documents read so far.
        examine: Check of a program with values of its parameters.
    """
    file = session.library.find(ProgramDocument, name, path)
    written = session.library.read_as_written(path, ProgramDocument).document
    known = {*written.assignable, *([ROBOT] if written.roles else ())}
    program = examine(path, {k: v for k, v in values.items() if k in known}, Diagnostics())
    document = session.library.read(path, ProgramDocument).document  # on the robot of the program
    other = UNKNOWN if file is None else examined(file, document, values, session, examine)
    if isinstance(program, Unknown) or isinstance(other, Unknown):
        return None, f"no valid program '{name}' for robot '{document.robot}'"
    substitute = _substitute(program, other)
    return substitute.program, substitute.refusal


def _wanted(document: ProgramDocument) -> set[str]:
    """Return the types of signals that programs in its place have to be rewarded for."""
    kinds = [allotment(group[WHOLE]) for group in document.resources.values() if WHOLE in group]
    return {each.type for each in kinds if each is not None and each.kind == PROGRAM}


def examined(
    file: Path,
    document: ProgramDocument,
    values: Mapping[str, str],
    session: Session,
    examine: Examine,
) -> Outcome[CheckedProgram]:
    """Return a program for the same robot with the values of common parameters."""
    try:
        other = session.library.read(file, ProgramDocument).document
    except DiagnosticsError:
        return UNKNOWN
    if other.robot != document.robot and not other.roles:
        return UNKNOWN
    on = {ROBOT: document.robot} if other.roles else {}
    given = {**document.parameters, **values}
    shared = {key: given[key] for key in other.assignable if key in given}
    diagnostics = Diagnostics()
    program = examine(file, {**on, **shared}, diagnostics)
    return UNKNOWN if diagnostics.failed else program


def _substitute(program: CheckedProgram, other: CheckedProgram) -> Allocation:
    values = {WHOLE: other.name}
    names = correspondence(program, other)
    if names is None:
        reason = f"its actions are not those of '{program.name}' in the abstract"
        return Allocation(values, values, None, reason)
    return Allocation(values, values, in_place_of(program, other, names), "")
