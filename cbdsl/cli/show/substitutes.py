"""``cb show substitutes``: programs that can replace a program, or a part of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from cbdsl.checking.program import check_program, examine_program, examiner
from cbdsl.checking.session import Session
from cbdsl.checking.substitution import examined
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.options import ShownProgram, With
from cbdsl.cli.output.terminal import print_json, print_table
from cbdsl.cli.show.formats import PLAIN, Format, Json, PlainFormat, read_format
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Unknown
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.stand_in import StandIn, stand_ins


def show_substitutes(
    name: ShownProgram,
    with_: With = [],  # noqa: B006 (typer)
    format_: PlainFormat = "text",
    as_json: Json = False,
) -> None:
    """Show programs with the same reward as a program, or as one of its members.

    The types of signals and effectors and the reward are compared, and names are ignored.
    """
    form = read_format(format_, as_json, PLAIN)
    session, values = Session(), read_assignments(with_)
    # Errors of the program itself are reported before anything is compared with it.
    check_program(name, values, session.library)
    path = session.library.locate(ProgramDocument, name)
    rows = [
        {"in place of": each.member, "program": each.program, "rewarded for": str(each.kind)}
        for each in stand_ins_of(path, session, values)
    ]
    if form is Format.JSON:
        print_json(rows)
    elif not rows:
        print(f"no program has a rewarded kind in common with {path.stem}")
    else:
        print_table(f"Substitutes in {path.stem}", rows)


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
