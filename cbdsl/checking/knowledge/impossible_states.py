"""States of a policy that cannot occur (Eq 4.1)."""

from __future__ import annotations

from collections.abc import Iterable

from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.controller import Controller
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Origin
from cbdsl.types.state import Predicate
from cbdsl.yaml_text.source_map import SourceMap

# The predicate - stands for a potential that cannot be computed, because a signal is undefined
# (Eq 4.1). Joints, kinematics, constants and drawn references have a value in every tick, while a
# camera may lose its object. Potentials have smaller domains, too, such as the free space of a
# harmonic function, or all points but the tip's own for ``look_at``.
_ALWAYS_KNOWN = frozenset({Origin.PROPRIOCEPTION, Origin.KINEMATICS, Origin.CONSTANT, Origin.MODEL})


def reads_what_is_known(controller: Controller) -> bool:
    """Return whether all resources that a controller reads are available at any time."""
    return all(resource.origin in _ALWAYS_KNOWN for resource in controller.resources)


def is_mostly_defined(controller: Controller) -> bool:
    """Return whether a controller has a residual at any time, but for single values of signals."""
    waits = (controller.standoff, controller.requires, controller.onset)
    is_residual = POTENTIALS[controller.potential].residual
    return is_residual and not any(waits) and reads_what_is_known(controller)


def is_always_defined(controller: Controller) -> bool:
    """Return whether the potential of a controller can certainly be computed at any time."""
    return POTENTIALS[controller.potential].total and is_mostly_defined(controller)


def check_possible(
    policy: Iterable[str], program: CheckedProgram, source: SourceMap, diagnostics: Diagnostics
) -> None:
    """Warn of states in which an always defined controller is undefined.

    Args:
        policy: Patterns, each as long as the program's states.
        program: Program whose members the letters stand for.
        source: Source map of the policy.
        diagnostics: Diagnostics so far.
    """
    leads = {name: primitive.lead for name, primitive in program.primitives.items()}
    known = {name for name, lead in leads.items() if is_always_defined(lead)}
    for pattern in policy:
        pairs = zip(program.members, pattern, strict=True)
        never = [name for name, letter in pairs if letter == Predicate.UNDEFINED and name in known]
        if never:
            diagnostics.add("CB717", source.key("policy", pattern), name=never[0])
