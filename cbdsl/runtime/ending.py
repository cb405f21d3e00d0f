"""Ending of an episode as a sentence, from the last readings of its controllers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from cbdsl.program.controller import AlongNormals, Controller, Literal, Relative
from cbdsl.runtime.causes import (
    BLOCKED,
    CREEPING,
    HELD,
    LIMITS,
    OUT_OF_REACH,
    RestCause,
    enumerated,
)
from cbdsl.runtime.controllers.controller_run import NEAR_GOAL, ControllerRun
from cbdsl.runtime.episode_observer import ReturnRequest
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Origin, Resource
from cbdsl.types.source_record import channel_of

# Keys for the configurations of prismatic joints, and of joints of both kinds.
_SLIDE, _MIXED = "slide", "configuration of both kinds"

# Reported units of errors by type: factor from SI, and unit.
_UNITS = {
    _MIXED: (1.0, "(rad and m)"),
    "position": (100.0, "cm"),
    "offset": (100.0, "cm"),
    "length": (100.0, "cm"),
    "force": (1.0, "N"),
    "heading": (180 / math.pi, "deg"),
    "orientation": (180 / math.pi, "deg"),
    "configuration": (180 / math.pi, "deg"),
    _SLIDE: (1000.0, "mm"),
}

# Share of an error by which it is as small as another.
_SAME = 0.02

_VERDICTS = {"success": "Succeeded", "failure": "Failed"}


def describe(
    run: ProgramRun,
    seconds: float,
    at_limits: Sequence[str],
    guards: Sequence[str] = (),
    causes: Mapping[str, RestCause | None] | None = None,
    colors: Sequence[str] | None = None,
) -> str:
    """Return a sentence on how a program ended and how its controllers contributed.

    Args:
        run: Run of the program, at its end.
        seconds: Duration, s.
        at_limits: Joints held back by their limits at the end.
        guards: One clause for each guard that limited the motion.
        causes: Causes that keep stuck controllers from their targets, by name.
        colors: Named colours that the cameras see; ``None`` if that explains nothing.
    """
    verdict = _VERDICTS.get(run.outcome, "Done" if run.predicate == "1" else "Not rewarded")
    if run.rewarded and not run.outcome:
        verdict = "Rewarded"
    # Intermediate rewards do not show whether the program reached its purpose.
    if run.program.success and not run.outcome and not run.program.reward_ends:
        verdict = "Neither succeeded nor failed"
    reasons = _evidence(run, causes or {})
    if colors is not None:
        reasons.append(f"the cameras see {' and '.join(colors) or 'no named colour'}")
    if at_limits and not (run.rewarded or run.outcome == "success"):
        reasons.append(f"at their limits were {', '.join(at_limits)}")
    if run.predicate != "1" or run.rewarded:
        reasons.append(run.ending)
    if not (run.rewarded or run.outcome == "success"):
        reasons.extend(run.losses)
    reasons.extend(guards)
    because = "; ".join(reason for reason in reasons if reason)
    return f"{verdict} after {seconds:.1f} s in state {run.state}: {because}."


def describe_lateness(run: ProgramRun, seconds: float, taken: float, deadline: float) -> str:
    """Return a sentence on an episode that ended because a control tick took too long.

    Args:
        run: Run of the program, where it stopped.
        seconds: Duration, s.
        taken: Wall time of the tick, s.
        deadline: Deadline of a tick, s.
    """
    return (
        f"Halted after {seconds:.1f} s in state {run.state}: a control tick took "
        f"{1000 * taken:.4g} ms, and the backend's deadline is {1000 * deadline:.4g} ms; "
        "references are frozen at the measured positions."
    )


def describe_stop(run: ProgramRun, seconds: float, cause: BaseException) -> str:
    """Return a sentence on an episode that was interrupted or failed.

    Args:
        run: Run of the program, where it stopped.
        seconds: Duration, s.
        cause: Exception that stopped it.
    """
    where = f"after {seconds:.1f} s in state {run.state}"
    if isinstance(cause, (KeyboardInterrupt, GeneratorExit, ReturnRequest)):
        return f"Interrupted {where}."
    return f"Failed {where}: {cause.__cause__ or cause}."


def stuck_leads(run: ProgramRun) -> tuple[ControllerRun, ...]:
    """Return the last action's controllers that are stuck, highest priority first."""
    action = run.action
    if action is None:
        return ()
    if action.program is not None:
        return stuck_leads(run.children[action.name])
    return tuple(lead for lead in run.leads(action) if lead.stuck)


def lacks_color(run: ProgramRun) -> bool:
    """Return whether a controller of the last action had no signal of a named colour."""
    action = run.action
    if action is None:
        return False
    if action.program is not None:
        return lacks_color(run.children[action.name])
    return any(
        math.isnan(lead.error)
        and not lead.lacks_hold
        and channel_of(_undefined_resource(lead.controller).source) in run.colors
        for lead in run.leads(action)
    )


def _evidence(run: ProgramRun, causes: Mapping[str, RestCause | None]) -> list[str]:
    """Return a clause for each member that the last action involved, highest priority first."""
    action = run.action
    if action is None:
        return []
    if action.program is not None:
        child = run.children[action.name]
        return [*_evidence(child, causes), child.ending]
    lacking: dict[str, list[str]] = {}
    clauses = []
    for lead in run.leads(action):
        required = _lacked(lead, run)
        if required is None:
            clauses.append(_clause(lead, causes.get(lead.controller.name)))
        else:
            lacking.setdefault(_absence(required), []).append(lead.controller.name)
    # Several controllers may lack the same one, such as the contact of a hand; it is described
    # once.
    for absence, names in lacking.items():
        verb = "requires" if len(names) == 1 else "require"
        together = " and ".join(names)
        clauses.append(f"{absence}, and {together} {verb} it")
    return clauses


def _lacked(lead: ControllerRun, run: ProgramRun) -> ControllerRun | None:
    """Return the controller that an undefined controller requires and lacks."""
    if not math.isnan(lead.error):
        return None
    for item in run.active():
        if item.run is lead:
            required = item.peers.get(lead.controller.requires or "")
            if required is None:
                return None
            # A seeking controller is engaged although undefined; the controller that requires it
            # may be undefined, too.
            lacks = not required.engaged or math.isnan(required.error)
            return required if lacks else None
    return None


def _absence(required: ControllerRun) -> str:
    """Return the lack of a required controller as a clause."""
    was_there = required.engaged or required.exhausted
    if required.controller.task.name == "force" and not was_there:
        return f"{required.controller.name} felt nothing"
    return _clause(required)


def _clause(lead: ControllerRun, cause: RestCause | None = None) -> str:
    controller = lead.controller
    if lead.astray:
        return f"{controller.name} felt something else than the object it sought"
    if lead.exhausted:
        return f"{controller.name} closed on nothing"
    if lead.preparation.no_path:
        return f"{controller.name} had no way: {lead.preparation.no_path}"
    if lead.lacks_hold:
        return f"{controller.name} moves a held object, and no hand holds one"
    if math.isnan(lead.error):
        return f"{controller.name} had no {_undefined_resource(controller).name}"
    verb = "came to rest" if lead.predicate == "1" else "was still"
    if lead.stuck:
        verb = f"is stuck{_reason(cause)},"
    if controller.reference is None:
        return f"{controller.name} {verb} at a potential of {lead.phi:.3g}"
    # The residual of a field is bounded: a distant goal is farther away than the residual.
    is_field = POTENTIALS[controller.potential].field
    at_least = "at least " if is_field and lead.phi > NEAR_GOAL else ""
    away = f"{at_least}{_measure(lead, lead.error)} from {_goal(controller)}"
    return f"{controller.name} {verb} {away}{_at_best(lead, cause)}"


def _reason(cause: RestCause | None) -> str:
    """Return the cause of a stuck controller, as words behind "is stuck"."""
    if cause is None:
        return ""
    limits = f"the limit{'s' if len(cause.joints) > 1 else ''} of {enumerated(cause.joints)}"
    holders = [limits if holder == LIMITS else holder for holder in cause.words]
    return {
        LIMITS: f" at {limits}",
        HELD: f", held by {enumerated(holders)}",
        BLOCKED: f", {cause}",
        CREEPING: ", still creeping",
        OUT_OF_REACH: " out of reach",
    }.get(cause.kind, f" at a {cause.kind}")


def _at_best(lead: ControllerRun, cause: RestCause | None) -> str:
    """Return the least distance from a reference out of reach, if another posture has it."""
    if cause is None or cause.kind != OUT_OF_REACH or lead.error <= (1.0 + _SAME) * cause.least:
        return ""
    return f" (another posture is {_measure(lead, cause.least)} away)"


def _measure(lead: ControllerRun, error: float) -> str:
    """Return an error in its reported unit."""
    factor, unit = _UNITS.get(_quantity(lead), (1.0, ""))
    return f"{factor * error:.{1 if unit else 3}f} {unit}".rstrip()


def _quantity(lead: ControllerRun) -> str:
    """Return the name of the error's type; configurations of other units have other names."""
    task = lead.controller.task
    if task.name != "configuration":
        return task.name
    units = set(task.units)
    return _SLIDE if units == {"m"} else _MIXED if "m" in units else task.name


def _goal(controller: Controller) -> str:
    reference = controller.reference
    if reference is None:
        return controller.feedback.name
    if isinstance(reference, (Literal, AlongNormals)):
        return "its reference"
    if isinstance(reference, Relative):
        return "its reference" if reference.base is None else f"beside {reference.base.name}"
    return reference.name


def _undefined_resource(controller: Controller) -> Resource:
    """Return the input that an undefined controller lacks."""
    reference = controller.reference
    base = reference.base if isinstance(reference, Relative) else reference
    if base is None or isinstance(base, (Literal, AlongNormals)):
        return controller.feedback
    return controller.feedback if controller.feedback.origin is Origin.ENVIRONMENT else base
