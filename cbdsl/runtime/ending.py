"""Why an episode ended: a sentence from the predicates that were last read."""

from __future__ import annotations

import math

from cbdsl.program.controller import AlongNormals, Controller, Literal
from cbdsl.runtime.controller_run import ControllerRun
from cbdsl.runtime.program_run import ProgramRun

# Errors of these types read better in another unit than SI's.
_UNITS = {
    "position": (100.0, "cm"),
    "force": (1.0, "N"),
    "heading": (180 / math.pi, "deg"),
    "orientation": (180 / math.pi, "deg"),
    "configuration": (180 / math.pi, "deg"),
}


def describe(run: ProgramRun, seconds: float) -> str:
    """A sentence that says how a program ended and what its controllers had to do with it."""
    innermost = run
    while innermost.action is not None and innermost.action.program is not None:
        innermost = innermost.children[innermost.action.name]
    clauses = [_clause(item) for item in innermost.runs if item.predicate != "X"]
    evidence = "; ".join(clause for clause in clauses if clause)
    verdict = (
        f"Rewarded after {seconds:.1f} s in state {run.state}"
        if run.rewarded
        else f"Not rewarded after {seconds:.1f} s: {_reason(run)}"
    )
    return f"{verdict}: {evidence}." if evidence else f"{verdict}."


def _reason(run: ProgramRun) -> str:
    """Its own reason, then those of a program that it was waiting for."""
    reasons = [run.ending]
    action = run.action
    if action is not None and action.program is not None:
        reasons.append(_reason(run.children[action.name]))
    return ", ".join(reason for reason in reasons if reason)


def _clause(item: ControllerRun) -> str:
    controller = item.controller
    if item.exhausted:
        return f"{controller.name} closed on nothing"
    if item.predicate == "-":
        return f"{controller.name} had no {_missing(item)}"
    factor, unit = _UNITS.get(controller.feedback.type.name, (1.0, ""))
    verb = "came to rest" if item.predicate == "1" else "was"
    return f"{controller.name} {verb} {factor * item.error:.1f} {unit} from {_goal(controller)}"


def _goal(controller: Controller) -> str:
    reference = controller.reference
    if reference is None:
        return "its minimum"
    if isinstance(reference, (Literal, AlongNormals)):
        return "its reference"
    return reference.name


def _missing(item: ControllerRun) -> str:
    controller = item.controller
    if controller.feedback.origin.name == "ENVIRONMENT":
        return controller.feedback.name
    return _goal(controller)
