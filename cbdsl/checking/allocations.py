"""Allocations of a program: possible values of its resources, by the type table (Section 5.3)."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from cbdsl.checking.open_members import MemberExchange, OpenMember
from cbdsl.checking.program import examine_program, examiner
from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.robot.role_effectors import carries, has_signal
from cbdsl.checking.session import Session
from cbdsl.checking.substitution import Allocation, substitutes
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.outcome import UNKNOWN, Unknown
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.channel_names import channel_names
from cbdsl.types.allotment import CHANNEL, PROGRAM, WHOLE, Allotment, allotment
from cbdsl.types.role import ROBOT

# Each allocation is checked as a program of its own.
_MOST = 500


def allocations(
    path: Path, session: Session, values: Mapping[str, str] | None = None
) -> list[Allocation]:
    """Return all allocations of a program's resources, fitting or not.

    Args:
        path: File of a program without diagnostics.
        session: Session with the documents read so far.
        values: Values of its other parameters that replace the defaults.

    Raises:
        UsageError: The program has more allocations than can be checked.
    """
    if session.library.read_as_written(path, ProgramDocument).document.roles:
        examine_program(path, values or {}, session, Diagnostics())  # binds them
    document = session.library.read(path, ProgramDocument).document
    file = session.library.find(RobotDocument, document.robot, path)
    robot = session.body(file or UNKNOWN, Diagnostics())
    if isinstance(robot, Unknown):
        return []
    groups = {
        name: list(_choices({key: allotment(text) for key, text in group.items()}, robot))
        for name, group in _own_groups(document).items()
    }
    # Groups are independent, so that their numbers of choices multiply.
    count = 1
    for choices in groups.values():
        count *= len(choices)
    if count > _MOST:
        raise UsageError(f"{path}: {count} allocations are more than the {_MOST} that are checked")
    on = {ROBOT: robot.document.name} if document.roles else {}
    given = {**on, **(values or {})}
    own = [
        _allocation(path, session, given, dict(zip(groups, choice, strict=True)), robot)
        for choice in itertools.product(*groups.values())
    ]
    examine = examiner(session)
    members, exchange = _open_members(document), MemberExchange(path, session, examine)
    exchanged = [
        each for base in own for member in members for each in exchange.allocations(base, member)
    ]
    return [*own, *exchanged, *substitutes(path, values or {}, session, examine)]


def _own_groups(document: ProgramDocument) -> dict[str, dict[str, str]]:
    """Return the groups of parameters that stand for resources other than programs."""
    groups = {
        name: {key: text for key, text in group.items() if not _is_program(text)}
        for name, group in document.resources.items()
    }
    return {name: group for name, group in groups.items() if group}


def _open_members(document: ProgramDocument) -> list[OpenMember]:
    """Return the members that the section ``resources`` declares as exchangeable."""
    return [
        OpenMember(name, key, wanted.type)
        for name, group in document.resources.items()
        for key, text in group.items()
        if (wanted := allotment(text)) is not None and wanted.kind == PROGRAM and key != WHOLE
    ]


def _is_program(text: str) -> bool:
    wanted = allotment(text)
    return wanted is not None and wanted.kind == PROGRAM


def _choices(
    wanted: Mapping[str, Allotment | None], robot: CheckedRobot
) -> Iterator[dict[str, str]]:
    """Yield values of the parameters of one group, each of the required kind."""
    candidates = [[] if each is None else _candidates(each, robot) for each in wanted.values()]
    for values in itertools.product(*candidates):
        yield dict(zip(wanted, values, strict=True))


def _candidates(wanted: Allotment, robot: CheckedRobot) -> list[str]:
    """Return the names of all resources of a robot that a parameter may stand for."""
    document = robot.document
    if wanted.kind == CHANNEL:
        return list(channel_names(document.vision.channels)) if document.cameras else []
    names = [*document.effectors, *document.groups]
    return [name for name in names if has_signal(wanted.type, name, robot)]


def _allocation(
    path: Path,
    session: Session,
    values: Mapping[str, str],
    groups: Mapping[str, Mapping[str, str]],
    robot: CheckedRobot,
) -> Allocation:
    chosen = {key: value for group in groups.values() for key, value in group.items()}
    choices = {name: next(iter(group.values()), "") for name, group in groups.items()}
    for group in groups.values():
        refusal = _apart(list(group.values()), robot)
        if refusal:
            return Allocation(chosen, choices, None, refusal)
    diagnostics = Diagnostics()
    program = examine_program(path, {**values, **chosen}, session, diagnostics)
    errors = [each for each in diagnostics.sorted() if each.is_error]
    if isinstance(program, Unknown) or errors:
        return Allocation(chosen, choices, None, errors[0].message if errors else "has findings")
    return Allocation(chosen, choices, program, "")


def _apart(names: Sequence[str], robot: CheckedRobot) -> str:
    """Return why jointly replaced effectors do not belong together; empty if they do."""
    effectors = [
        name for name in names if name in {*robot.document.effectors, *robot.document.groups}
    ]
    for one, other in itertools.pairwise(effectors):
        if not carries(one, other, robot) and not carries(other, one, robot):
            return f"'{other}' is not mounted on '{one}'"
    return ""
