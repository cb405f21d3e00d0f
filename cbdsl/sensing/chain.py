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
    Heading,
    Headings,
    MarkHeading,
    NetForces,
    NetLoad,
    NovelHeading,
    Posture,
    Resource,
    SensorSignal,
    Separation,
    StereoOffset,
    StereoPosition,
    Tip,
)

MANIPULATOR = "inverse manipulator Jacobian"
_COMPLIANCE = "compliance"

_JOINTS: frozenset[tuple[str, ...]] = frozenset({()})
_ARMS = frozenset({(MANIPULATOR,)})
_LOADS = frozenset({(_COMPLIANCE,)})
_TURNS = frozenset({(each.name,) for each in CAMERA_TURNS})
_HELD = RIGID_HOLD.name, MANIPULATOR

#: By kind of source, the chains whose Jacobians its rows can be compiled from: names of casts.
EXECUTED: Mapping[type, frozenset[tuple[str, ...]]] = {
    EffectorConfiguration: _JOINTS,
    Posture: _JOINTS,
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
}


class CastError(Exception):
    """A chain of casts that no row executes; the message names it."""


def require_executed(resource: Resource, chains: tuple[Chain, ...]) -> None:
    """Refuse chains that a resource's row would not have the Jacobian of.

    Raises:
        CastError: one of them is none that rows of such a source are compiled from.
    """
    if isinstance(resource.source, SensorSignal):
        return  # whose reader gives the whole Jacobian
    executed = EXECUTED.get(type(resource.source), frozenset())
    for chain in chains:
        if tuple(cast.name for cast in chain) not in executed:
            casts = " → ".join(map(str, chain)) or "no cast"
            raise CastError(f"no row of {resource.name} executes {casts}")


def carry(chain: Chain, steps: Mapping[str, Callable[[Any], Any]]) -> Any:
    """Displacements per joint, carried along a chain from the joints to the feedback.

    Args:
        chain: from the feedback to the joints.
        steps: by name of a cast, displacements per joint of its source from those of its target;
            the last cast of a chain gets ``None``, for the joints themselves.
    """
    carried = None
    for cast in reversed(chain):
        carried = steps[cast.name](carried)
    return carried
