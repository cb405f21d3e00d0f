"""Chains of casts as the rows of the signal table execute them (section 3.2.4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from cbdsl.types.casts import CAMERA, CAMERA_TURNS, RIGID_HOLD, SIGHTING, TRIANGULATION, Chain
from cbdsl.types.resource import (
    Centroid,
    ConstellationSignal,
    EffectorConfiguration,
    FingerForces,
    FingerLoad,
    GraspCentre,
    Heading,
    Headings,
    MarkHeading,
    ModelSignal,
    NetForces,
    NetLoad,
    NovelHeading,
    Opening,
    PairLikeness,
    Posture,
    Resource,
    SensorSignal,
    Separation,
    SolidSignal,
    StereoOffset,
    StereoPosition,
    Tip,
    Turned,
)

MANIPULATOR = "inverse manipulator Jacobian"
_COMPLIANCE = "compliance"

_JOINTS: frozenset[tuple[str, ...]] = frozenset({()})
_ARMS = frozenset({(MANIPULATOR,)})
_LOADS = frozenset({(_COMPLIANCE,)})
_TURNS = frozenset({(each.name,) for each in CAMERA_TURNS})
_HELD = RIGID_HOLD.name, MANIPULATOR
#: Chains of rows whose readers return the whole Jacobian.
WHOLE = frozenset({("whole Jacobian",)})

#: Chains of casts, by name, from which rows compile their Jacobians, by kind of source.
EXECUTED: Mapping[type, frozenset[tuple[str, ...]]] = {
    SensorSignal: WHOLE,
    ModelSignal: WHOLE,
    EffectorConfiguration: _JOINTS,
    Posture: _JOINTS,
    Turned: _JOINTS,
    Tip: _ARMS,
    Centroid: _ARMS,
    Separation: _ARMS,
    FingerLoad: _LOADS,
    NetLoad: _LOADS,
    NetForces: _LOADS,
    FingerForces: _LOADS,
    Heading: frozenset({(CAMERA.name,), (SIGHTING.name, *_HELD)}),
    Headings: frozenset({(CAMERA.name,), (TRIANGULATION.name, *_HELD)}),
    StereoPosition: frozenset({_HELD}),
    NovelHeading: frozenset({(CAMERA.name,)}),
    MarkHeading: frozenset({(CAMERA.name,)}),
    ConstellationSignal: _TURNS,
    StereoOffset: _TURNS,
    SolidSignal: _TURNS,
    PairLikeness: _TURNS,
    Opening: _ARMS,
    GraspCentre: _ARMS,
}


class CastError(Exception):
    """Chain of casts that no row can execute, which the message names."""


def require_executed(resource: Resource, chains: tuple[Chain, ...]) -> None:
    """Raise an error for chains that the rows of a resource cannot execute.

    Raises:
        CastError: No row of such a source is compiled from one of the chains.
    """
    executed = EXECUTED.get(type(resource.source), frozenset())
    for chain in () if executed is WHOLE else chains:
        if tuple(cast.name for cast in chain) not in executed:
            casts = " → ".join(map(str, chain)) or "no cast"
            raise CastError(f"no row of {resource.name} executes {casts}")


def carry(chain: Chain, steps: Mapping[str, Callable[[Any], Any]]) -> Any:
    """Return displacements per joint, propagated along a chain from the joints to the feedback.

    Args:
        chain: Casts from the feedback to the joints.
        steps: Functions by name of a cast: they map displacements per joint of the cast's target to
            those of its source. The last cast of a chain gets ``None``, for the joints themselves.
    """
    carried = None
    for cast in reversed(chain):
        carried = steps[cast.name](carried)
    return carried
