"""Check of programs for possible rewards (Eq 4.2 to 4.4)."""

from __future__ import annotations

from pathlib import Path

from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.dry_run import controllers
from cbdsl.yaml_text.library import Library


def check_rewarded(program: CheckedProgram, path: Path, library: Library) -> tuple[Diagnostic, ...]:
    """Warn of a program that cannot be learned because none of its actions is rewarded.

    Args:
        program: Checked program.
        path: File of the program.
        library: Library that has read it.
    """
    # A reward is an event of quiescence of a controller whose feedback comes from the environment
    # (Eq 4.2, 4.3). Without such a controller, every action is worth the same to a learner.
    if any(primitive.rewarded for primitive in program.primitives.values()):
        return ()
    diagnostics, source = Diagnostics(), library.read(path, ProgramDocument).source
    hidden = [controller.name for controller in controllers(program) if controller.rewarded]
    used = [action.name for action in program.actions if action.program is not None]
    why = "none of its actions is a controller that measures a heading or a force"
    if hidden:
        why = f"'{hidden[0]}', which could be, is not an action by itself"
    elif used:
        why = f"what '{used[0]}' earns is its own, and {why}"
    diagnostics.add("CB720", source.key("actions"), name=program.name, why=why)
    return diagnostics.sorted()
