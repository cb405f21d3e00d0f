"""Allocations of a program's resources: all that fit, one by one or behind one choice."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.program.checked import CheckedProgram


def allocated(request: RunRequest, policy: str | Path) -> CheckedProgram:
    """Return a program with all its allocations, without any learned choice between them.

    Args:
        request: Program, under any policy.
        policy: File or name of the policy of each allocation.

    Raises:
        DiagnosticsError: The policy has errors.
        UsageError: Less than two allocations fit, or no controller uses a seen position.
    """
    from cbdsl.api.requests.run_request import read_policy
    from cbdsl.checking.assimilation import program_to_assimilate
    from cbdsl.checking.session import Session

    loaded = read_policy(request.program, str(policy), request.program_file, request.library)
    session = Session(request.library)
    return program_to_assimilate(request.program_file, loaded, session, request.values)


def allocations(request: RunRequest) -> dict[str, CheckedProgram]:
    """Return a program under each allocation that fits, by name, its own one first."""
    from cbdsl.checking.assimilation import variants_of
    from cbdsl.checking.session import Session

    return variants_of(request.program_file, Session(request.library), request.values)


def exchanged(request: RunRequest, member: str, program: str) -> CheckedProgram:
    """Return a program with another program in the place of a member.

    Both have to be rewarded for signals of the same kind. The policy is kept.

    Args:
        request: Program with the member.
        member: Name of the member.
        program: Name of the program that takes its place.

    Raises:
        UsageError: The program cannot take the place of the member.
    """
    from cbdsl.checking.open_members import MemberExchange
    from cbdsl.checking.program import examiner
    from cbdsl.checking.session import Session
    from cbdsl.diagnostics.errors import UsageError

    session = Session(request.library)
    exchange = MemberExchange(request.program_file, session, examiner(session))
    changed, refusal = exchange.exchanged(request.program, member, program)
    if changed is None:
        raise UsageError(f"'{program}' cannot take the place of '{member}': {refusal}")
    return changed
