"""Programs of a library that can stand in for members of another program (Section 5.3.2)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from cbdsl.checking.program import examine_program, examiner
from cbdsl.checking.session import Session
from cbdsl.checking.substitution import examined
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Unknown
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.stand_in import StandIn, stand_ins


def stand_ins_of(path: Path, session: Session, values: Mapping[str, str]) -> list[StandIn]:
    """Return all stand-ins in the order of the members, without programs that have diagnostics.

    Args:
        path: File of a program without diagnostics.
        session: Session with the documents read so far.
        values: Values of its parameters; other programs take over the values of common parameters.
    """
    program = examine_program(path, values, session, Diagnostics())
    if isinstance(program, Unknown):
        return []
    all_of_them = [
        each for other in _others(path, session, values) for each in stand_ins(program, other)
    ]
    return sorted(all_of_them, key=lambda each: program.members.index(each.member))


def _others(path: Path, session: Session, values: Mapping[str, str]) -> Iterator[CheckedProgram]:
    library = session.library
    document, examine = library.read(path, ProgramDocument).document, examiner(session)
    for name in library.names(ProgramDocument, path):
        file = library.find(ProgramDocument, name, path)
        if file is not None and library.real(file) != library.real(path):
            other = examined(file, document, values, session, examine)
            if not isinstance(other, Unknown):
                yield other
