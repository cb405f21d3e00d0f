"""Ending of an episode: a sentence from the last readings of its controllers."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cbdsl.program.controller import AlongNormals, Controller, Literal, Relative
from cbdsl.runtime.controller_run import ControllerRun
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Origin

# Configurations of joints that slide.
_SLIDE = "slide"

# How errors of these types are told: factor from SI, and unit.
_UNITS = {
    "position": (100.0, "cm"),
    "offset": (100.0, "cm"),
    "force": (1.0, "N"),
    "heading": (180 / math.pi, "deg"),
    "orientation": (180 / math.pi, "deg"),
    "configuration": (180 / math.pi, "deg"),
    _SLIDE: (1000.0, "mm"),
}

#: Error beyond which what came to rest has not arrived, in SI, where no tolerance says it.
_FAR = {
    "position": 0.02,
    "heading": math.radians(5),
    "orientation": math.radians(5),
    "configuration": math.radians(5),
    _SLIDE: 0.005,
}

_VERDICTS = {"success": "Succeeded", "failure": "Failed"}

# Potential below which a field's displacement leads to its goal itself.
_NEAR = 1e-2


def describe(
    run: ProgramRun,
    seconds: float,
    at_limits: Sequence[str],
    guards: Sequence[str] = (),
    stuck: Sequence[str] = (),
) -> str:
    """Sentence on how a program ended and what its controllers had to do with it.

    Args:
        run: the program, at its end.
        seconds: how long it ran.
        at_limits: joints that their limits held back at the end.
        guards: a clause for each guard that the motion gave way to.
        stuck: Levels at the nearest point to their targets, highest priority first.
    """
    verdict = _VERDICTS.get(run.outcome, "Done" if run.predicate == "1" else "Not rewarded")
    if run.rewarded and not run.outcome:
        verdict = "Rewarded"
    # Rewards on the way say nothing of what the program is for.
    if run.program.success and not run.outcome and not run.program.reward_ends:
        verdict = "Neither succeeded nor failed"
    reasons = _evidence(run, stuck)
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
    """Sentence on an episode that ended because a control tick took too long.

    Args:
        run: the program, where it stopped.
        seconds: how long it ran.
        taken: by the tick, wall time, s.
        deadline: of a tick, s.
    """
    return (
        f"Halted after {seconds:.1f} s in state {run.state}: a control tick took "
        f"{1000 * taken:.4g} ms, and the backend's deadline is {1000 * deadline:.4g} ms; "
        "references are frozen at the measured positions."
    )


def describe_stop(run: ProgramRun, seconds: float, cause: BaseException) -> str:
    """Sentence on an episode that was interrupted, or failed.

    Args:
        run: the program, where it stopped.
        seconds: how long it ran.
        cause: what stopped it.
    """
    where = f"after {seconds:.1f} s in state {run.state}"
    if isinstance(cause, (KeyboardInterrupt, GeneratorExit)):
        return f"Interrupted {where}."
    return f"Failed {where}: {cause.__cause__ or cause}."


def stayed_far(run: ProgramRun) -> tuple[str, ...]:
    """Controllers of the last action at rest far from their goals, highest priority first."""
    action = run.action
    if action is None:
        return ()
    if action.program is not None:
        return stayed_far(run.children[action.name])
    leads = run.leads(action)
    return tuple(lead.controller.name for lead in leads if lead.predicate == "1" and is_far(lead))


def _evidence(run: ProgramRun, stuck: Sequence[str]) -> list[str]:
    """A clause for each member that its last action involved, highest priority first."""
    action = run.action
    if action is None:
        return []
    if action.program is not None:
        child = run.children[action.name]
        return [*_evidence(child, stuck), child.ending]
    lacking: dict[str, list[str]] = {}
    clauses = []
    for lead in run.leads(action):
        required = _lacked(lead, run)
        if required is None:
            clauses.append(_clause(lead, stuck))
        else:
            lacking.setdefault(_absence(required), []).append(lead.controller.name)
    for absence, names in lacking.items():
        verb = "requires" if len(names) == 1 else "require"
        together = " and ".join(names)
        clauses.append(f"{absence}, and {together} {verb} it")
    return clauses


def _lacked(lead: ControllerRun, run: ProgramRun) -> ControllerRun | None:
    """The controller that another one requires and does not have."""
    if not math.isnan(lead.error):
        return None
    for item in run.active():
        if item.run is lead:
            required = item.peers.get(lead.controller.requires or "")
            if required is None:
                return None
            # What seeks to be defined again is engaged, and what requires it may be undefined.
            lacks = not required.engaged or math.isnan(required.error)
            return required if lacks else None
    return None


def _absence(required: ControllerRun) -> str:
    """Lack of a required controller, as a clause."""
    was_there = required.engaged or required.exhausted
    if required.controller.task.name == "force" and not was_there:
        return f"{required.controller.name} felt nothing"
    return _clause(required)


def _clause(lead: ControllerRun, stuck: Sequence[str] = ()) -> str:
    controller = lead.controller
    if lead.exhausted:
        return f"{controller.name} closed on nothing"
    if lead.preparation.no_path:
        return f"{controller.name} had no way: {lead.preparation.no_path}"
    if math.isnan(lead.error):
        return f"{controller.name} had no {_undefined_resource(controller)}"
    verb = "came to rest" if lead.predicate == "1" else "was still"
    if lead.predicate == "1" and is_far(lead):
        verb = "came to rest far from its goal,"
        if controller.name in stuck:
            verb = f"came to rest {_nearest(lead, stuck)},"
    if controller.reference is None:
        return f"{controller.name} {verb} at a potential of {lead.phi:.3g}"
    factor, unit = _UNITS.get(_quantity(lead), (1.0, ""))
    # The residual of a field is bounded: far from the goal the goal is farther away than that.
    is_field = POTENTIALS[controller.potential].field
    at_least = "at least " if is_field and lead.phi > _NEAR else ""
    distance = f"{at_least}{factor * lead.error:.{1 if unit else 3}f} {unit}".rstrip()
    return f"{controller.name} {verb} {distance} from {_goal(controller)}"


def _nearest(lead: ControllerRun, stuck: Sequence[str]) -> str:
    """Return where a level is that gets no nearer to its target."""
    is_first = lead.controller.name == stuck[0]
    return "at the nearest point within reach" if is_first else "as near as higher levels allow"


def is_far(lead: ControllerRun) -> bool:
    """Whether an error is larger than what its tolerance allows, or than people call near."""
    if not lead.settled:
        return True
    if lead.controller.quiescence.tolerance is not None:
        return False
    return lead.error > _FAR.get(_quantity(lead), math.inf)


def _quantity(lead: ControllerRun) -> str:
    """Return the name of the error's type; that of joints which slide has its own unit."""
    kind = lead.controller.task.name
    return _SLIDE if kind == "configuration" and lead.slides else kind


def _goal(controller: Controller) -> str:
    reference = controller.reference
    if reference is None:
        return controller.feedback.name
    if isinstance(reference, (Literal, AlongNormals)):
        return "its reference"
    if isinstance(reference, Relative):
        return "its reference" if reference.base is None else f"beside {reference.base.name}"
    return reference.name


def _undefined_resource(controller: Controller) -> str:
    is_constant = isinstance(controller.reference, (Literal, AlongNormals))
    if is_constant or controller.feedback.origin is Origin.ENVIRONMENT:
        return controller.feedback.name
    return _goal(controller)
