"""Programs of a library in the place of another program's member, and reasons for refusals."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from cbdsl.checking.session import Session
from cbdsl.checking.substitution import Allocation, Examine
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.member_exchange import (
    EarnedSignal,
    earned_signals,
    exchange,
    member_places,
    member_program,
    member_signals,
    places_seen,
    signals_at_its_end,
)
from cbdsl.program.stand_in import used_names
from cbdsl.types.role import ROBOT


class OpenMember(NamedTuple):
    """Exchangeable member of a program.

    Attributes:
        group: Name of its group in the section ``resources``.
        member: Name of the member.
        type: Type of the signals that a program in its place has to be rewarded for.
    """

    group: str
    member: str
    type: str


class MemberExchange:
    """Exchange of members for other programs.

    Args:
        path: File of the program whose members are exchanged, without diagnostics.
        session: Session with the documents read so far.
        examine: Check of a program with values of its parameters.
    """

    def __init__(self, path: Path, session: Session, examine: Examine) -> None:
        self._path, self._library, self._examine = path, session.library, examine
        self._checked: dict[tuple[str, tuple[tuple[str, str], ...]], Outcome[CheckedProgram]] = {}

    def allocations(self, base: Allocation, member: OpenMember) -> Iterator[Allocation]:
        """Yield an allocation for each program of the library with a reward of the same kind.

        Args:
            base: Allocation that fits.
            member: Exchanged member.
        """
        program = base.program
        if program is None:
            return
        wanted = _of_type(member_signals(program, member.member), member.type)
        kinds = {each.kind for each in wanted}
        for name in self._library.names(ProgramDocument, self._path):
            some = next(iter(self._candidates(program, member.member, name)), None)
            if some is None or some.name == _current(program, member.member):
                continue
            if not kinds & {each.kind for each in earned_signals(some)}:
                continue
            exchanged, refusal = self.exchanged(program, member.member, name)
            yield Allocation(
                {**base.values, member.member: name},
                {**base.choices, member.group: name},
                exchanged,
                refusal,
            )

    def exchanged(
        self, program: CheckedProgram, member: str, name: str
    ) -> tuple[CheckedProgram | None, str]:
        """Return a program with another one in the place of a member, or ``None`` with the reason.

        The other program takes over the channels of the member's program, and also its effectors
        if they are needed. It has to end with the signal at rest that the member is rewarded for,
        because later actions depend on it. It also has to use the same seen positions.

        Args:
            program: Program under values of its parameters.
            member: Name of one of its members.
            name: Name of the other program.
        """
        candidates = list(self._candidates(program, member, name))
        if not candidates:
            return None, f"no valid program '{name}' for robot '{program.robot}'"
        if program.name in used_names(candidates[0]):
            return None, f"'{name}' uses '{program.name}' itself"
        own = member_program(program, member)
        if own is not None and name in used_names(own):
            return None, f"'{own.name}' uses '{name}' itself"
        wanted, places = member_signals(program, member), member_places(program, member)
        reason = ""
        for other in candidates:
            reason = _refusal(wanted, places, other)
            if not reason:
                return exchange(program, member, other), ""
        return None, reason

    def _candidates(
        self, program: CheckedProgram, member: str, name: str
    ) -> Iterator[CheckedProgram]:
        """Yield the other program with its own effectors, and with the member's effectors."""
        file = self._library.find(ProgramDocument, name, self._path)
        if file is None or self._library.real(file) == self._library.real(self._path):
            return
        try:
            document = self._library.read(file, ProgramDocument).document
        except DiagnosticsError:
            return
        if document.robot != program.robot and not document.roles:
            return
        on = {ROBOT: program.robot} if document.roles else {}
        given = _given(program, member)
        shared = {key: given[key] for key in document.assignable if key in given}
        effectors = self._effectors(program.robot)
        seen = {key: value for key, value in shared.items() if value not in effectors}
        # A substitute keeps its own effectors if it fits with them. A transfer between hands, for
        # example, uses other effectors than the grasp that it replaces.
        for values in ({**on, **seen}, {**on, **shared}):
            key = name, tuple(values.items())
            if key not in self._checked:
                diagnostics = Diagnostics()
                other = self._examine(file, values, diagnostics)
                self._checked[key] = UNKNOWN if diagnostics.failed else other
            checked = self._checked[key]
            if not isinstance(checked, Unknown):
                yield checked

    def _effectors(self, robot: str) -> Collection[str]:
        file = self._library.find(RobotDocument, robot, self._path)
        if file is None:
            return ()
        document = self._library.read(file, RobotDocument).document
        return {*document.effectors, *document.groups}


def _given(program: CheckedProgram, member: str) -> Mapping[str, str]:
    """Return the parameters of a member that is a program, otherwise the program's own."""
    child = member_program(program, member)
    return program.parameters if child is None else child.parameters


def _current(program: CheckedProgram, member: str) -> str:
    """Return the name of the program that a member is; empty for a controller."""
    child = member_program(program, member)
    return "" if child is None else child.name


def _of_type(signals: Collection[EarnedSignal], type_: str) -> set[EarnedSignal]:
    return {each for each in signals if each.kind.feedback == type_}


def _refusal(
    wanted: Collection[EarnedSignal], places: Collection[str], other: CheckedProgram
) -> str:
    """Return why a program cannot stand in for a member; empty if it can."""
    # Requirements come from general to special: kind of the reward, its signal, its rest at the
    # end, and the positions that the motion depends on.
    earned = earned_signals(other)
    kinds = sorted({str(each.kind) for each in wanted})
    if not {each.kind for each in wanted} & {each.kind for each in earned}:
        return f"'{other.name}' is not rewarded for {' or '.join(kinds)}"
    if not set(wanted) & earned:
        ours = " or ".join(sorted({each.signal for each in wanted}))
        theirs = " and ".join(sorted({each.signal for each in earned}))
        return f"'{other.name}' is rewarded for {theirs}, and this program goes by {ours}"
    if not set(wanted) & signals_at_its_end(other):
        return f"'{other.name}' does not end with its rewarded signals"
    missing = sorted(set(places) - places_seen(other))
    if missing:
        return f"'{other.name}' does not go by {' and '.join(missing)}"
    return ""
