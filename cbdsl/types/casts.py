"""The casts between types of signals, and the chains of them that controllers use (section 3.2.4).

A controller displaces its feedback by moving its effector. A chain of casts therefore carries a
small displacement of the feedback's type over to one of the effector's type: through the Jacobian
of a transformation, or through its pseudoinverse. The chains that lead on to the joints are data
of a controller, and its row of the signal table is compiled from them.
"""

from collections import deque
from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

from cbdsl.types.resource import (
    Heading,
    Headings,
    MarkHeading,
    NovelHeading,
    Resource,
    StereoPosition,
)
from cbdsl.types.resource_type import POSITION, ResourceType, configuration


class Cast(NamedTuple):
    """One edge of the cast graph.

    Attributes:
        name: the transformation.
        source: name of the type that it takes.
        target: name of the type that it gives.
        equation: where it is defined.
        factors: how many signals of the source's type it takes.
        value: whether it gives values; otherwise it carries displacements only.
    """

    name: str
    source: str
    target: str
    equation: str
    factors: int = 1
    value: bool = True

    def __str__(self) -> str:
        return f"{self.name} ({self.equation})"


Chain = tuple[Cast, ...]
"""Casts, each from the type that the one before gives."""

_KINEMATICS = {"position": "Eq 3.11", "orientation": "Eq 3.12", "pose": "Eq 3.11, 3.12"}

CAMERA = Cast("inverse camera Jacobian", "heading", "configuration", "section 3.2.2", value=False)
#: No turn of a camera displaces how two things are to each other: these are watched.
CAMERA_TURNS = tuple(
    Cast("turn of a camera", kind, "configuration", "Fig 7.15", value=False)
    for kind in ("constellation", "offset")
)
TRIANGULATION = Cast("stereo triangulation", "heading", "position", "Eq 3.14", factors=2)

CASTS: tuple[Cast, ...] = (
    *(
        Cast("forward kinematics", "configuration", part, equation)
        for part, equation in _KINEMATICS.items()
    ),
    *(
        Cast("inverse manipulator Jacobian", part, "configuration", equation, value=False)
        for part, equation in _KINEMATICS.items()
    ),
    CAMERA,
    *CAMERA_TURNS,
    TRIANGULATION,
    Cast("oculomotor Jacobian", "position", "heading", "section 3.2.2", value=False),
    *(
        Cast("compliance", load, "configuration", "Eq 3.37", value=False)
        for load in ("force", "torque", "wrench")
    ),
)

#: Types that no cast leads from, and why not: their signals are features, never feedback.
FEATURES: Mapping[str, str] = {
    "velocity": "joints displace what they move, and a velocity is no displacement",
    "volume": "no joint changes how large a thing is",
    "count": "no joint changes how many things there are",
    "probability": "no joint moves what is expected",
    "heading_rate": "joints displace what they move, and a rate is no displacement",
    "extent": "how a thing's outline changes as it turns depends on its shape, which is not known",
    "axis": "how a thing's outline changes as it turns depends on its shape, which is not known",
}

#: How something that a hand holds moves with the hand; between the chains to and from its position.
RIGID_HOLD = Cast("rigid hold", "position", "position", "Eq 3.42", value=False)
SIGHTING = Cast("inverse sighting Jacobian", "heading", "position", "section 3.2.2", value=False)


def chains_of(resource: Resource) -> tuple[Chain, ...]:
    """The chains from a resource to the joints, whose Jacobians add up to its own.

    A heading changes as the cameras turn, and as the hands move that hold what it leads to.
    """
    source, kind, joints = resource.source, resource.type, configuration(1)
    held = (RIGID_HOLD, *chains(POSITION, joints)[0])
    if isinstance(source, Heading):
        return (CAMERA,), (SIGHTING, *held)
    if isinstance(source, (NovelHeading, MarkHeading)):
        return ((CAMERA,),)
    if isinstance(source, Headings):
        return (CAMERA,), (TRIANGULATION, *held)
    if isinstance(source, StereoPosition):
        return (held,)
    return chains(kind, joints)[:1]


@cache
def chains(start: ResourceType, goal: ResourceType) -> tuple[Chain, ...]:
    """The shortest chains of casts from one type to another, by breadth-first search.

    A product is cast component by component, except where a cast takes several signals at once.

    Returns:
        All chains of the least length: one without casts for equal types, none where there is none.
    """
    shortest: list[Chain] = []
    waiting: deque[Chain] = deque([()])
    while waiting:
        chain = waiting.popleft()
        if shortest and len(chain) > len(shortest[0]):
            break
        at = chain[-1].target if chain else start.name
        if at == goal.name:
            shortest.append(chain)
            continue
        seen = {start.name, *(cast.target for cast in chain)}
        waiting.extend(
            (*chain, cast)
            for cast in CASTS
            if cast.source == at
            and cast.target not in seen
            and (cast.factors == 1 or (not chain and cast.factors == start.factors))
        )
    return tuple(shortest)
