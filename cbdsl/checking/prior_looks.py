"""Looks: programs that find the objects of a schema's features before the allocation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from cbdsl.checking.knowledge.policy_agreement import check_policy, with_policy
from cbdsl.checking.session import Session
from cbdsl.checking.substitution import Examine
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.outcome import UNKNOWN, Unknown
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument, Use
from cbdsl.program.checked import CheckedProgram, PriorLook
from cbdsl.program.member_exchange import earned_signals
from cbdsl.types.resource import Resource

_HEADING = "heading"


def look_of(
    use: Use, values: Mapping[str, str], beside: Path, session: Session, examine: Examine
) -> PriorLook | str:
    """Return a program that defines a feature, or the reason why it cannot be run.

    Args:
        use: Reference to the program, and to its policy if that is learned.
        values: Values of its parameters.
        beside: Document that names it.
        session: Session with the documents read so far.
        examine: Check of a program with values of its parameters.
    """
    library, diagnostics = session.library, Diagnostics()
    path = library.find(ProgramDocument, use.program, beside)
    if path is None:
        return f"unknown program '{use.program}'"
    known = library.read(path, ProgramDocument).document.assignable
    for key in values:
        if key not in known:
            return f"it has no parameter '{key}'"
    program = examine(path, values, diagnostics)
    if not isinstance(program, Unknown) and use.policy is not None and not diagnostics.failed:
        file = library.find(PolicyDocument, use.policy, beside)
        if file is None:
            return f"unknown policy '{use.policy}'"
        try:
            loaded = library.read(file, PolicyDocument)
        except DiagnosticsError:
            return f"policy '{use.policy}' has findings of its own"
        if loaded.document.program != program.name:
            return f"policy '{use.policy}' is one of '{loaded.document.program}'"
        check_policy(loaded, program, path, session, diagnostics)
        program = with_policy(program, loaded, library)
    if isinstance(program, Unknown) or diagnostics.failed:
        fault = next((each for each in diagnostics.sorted() if each.is_error), None)
        return fault.message if fault else "it has findings"
    return PriorLook(program, use.program, use.policy, dict(values))


def derived_looks(
    program: CheckedProgram,
    features: Mapping[str, Resource],
    path: Path,
    session: Session,
    examine: Examine,
) -> dict[str, PriorLook]:
    """Return the look for each object that features belong to, in their order.

    A program with an action that looks for objects needs no look. Otherwise the look is the first
    used program that is rewarded for a channel's heading, with the feature's channel instead.

    Args:
        program: Program under its own allocation.
        features: Resources of its context, by name.
        path: File of the program.
        session: Session with the documents read so far.
        examine: Check of a program with values of its parameters.
    """
    if any(
        action.program is not None and _looked_for(action.program) for action in program.actions
    ):
        return {}
    for file, use in _uses(path, session, set()):
        looking = session.library.find(ProgramDocument, use.program, file)
        plain = UNKNOWN if looking is None else examine(looking, {}, Diagnostics())
        parameter = None if isinstance(plain, Unknown) else _looked_for(plain)
        if parameter is None:
            continue
        looks: dict[str, PriorLook] = {}
        for name, resource in features.items():
            channel = resource.name.partition(".")[2]
            look = look_of(use, {parameter: channel}, file, session, examine)
            if isinstance(look, PriorLook):
                looks[name] = look
        return looks
    return {}


def _looked_for(program: CheckedProgram) -> str | None:
    """Return the parameter for the channel whose heading rewards a program, or ``None``."""
    for earned in earned_signals(program):
        if earned.kind.feedback == _HEADING:
            channel = earned.signal.partition(".")[2]
            return next((k for k, value in program.parameters.items() if value == channel), None)
    return None


def _uses(path: Path, session: Session, seen: set[Path]) -> Iterator[tuple[Path, Use]]:
    """Yield the programs that a program uses, at any depth, with the file that names each."""
    if path in seen:
        return
    seen.add(path)
    document = session.library.read(path, ProgramDocument).document
    for use in document.use.values():
        yield path, use
        used = session.library.find(ProgramDocument, use.program, path)
        if used is not None:
            yield from _uses(used, session, seen)
