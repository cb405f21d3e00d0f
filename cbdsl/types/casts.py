"""Casts between types of signals, and the chains of casts that controllers use (section 3.2.4).

A controller displaces its feedback by moving its effector. A chain of casts therefore maps a small
displacement of the feedback's type to a displacement of the effector's type. Each cast uses the
Jacobian of a transformation, or its pseudoinverse. The chains that lead to the joints are data of
a controller, and its row of the signal table is compiled from them.
"""

from collections import deque
from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

from cbdsl.types.resource_type import ResourceType


class Cast(NamedTuple):
    """Edge of the cast graph.

    Attributes:
        name: Name of the transformation.
        source: Name of the input type.
        target: Name of the output type.
        equation: Equation, section or figure that defines it.
        factors: Number of input signals of the source's type.
        value: True if it maps values; otherwise it maps displacements only.
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
"""Sequence of casts; the output type of each is the input type of the next."""

_KINEMATICS = {
    "position": "Eq 3.11",
    "orientation": "Eq 3.12",
    "pose": "Eq 3.11, 3.12",
    "length": "Eq 3.11",
}

CAMERA = Cast("inverse camera Jacobian", "heading", "configuration", "section 3.2.2", value=False)
#: No turn of a camera changes the relation of two objects; such signals are only observed.
CAMERA_TURNS = tuple(
    Cast("turn of a camera", kind, "configuration", "Fig 7.15", value=False)
    for kind in ("constellation", "offset", "likeness")
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
        # The stiffness of a contact is not measured; control assumes constants of the robot
        # document.
        Cast("compliance", load, "configuration", "Eq 3.37", value=False)
        for load in ("force", "torque", "wrench")
    ),
)

#: Types without outgoing casts, with the reason: their signals are features, never feedback.
FEATURES: Mapping[str, str] = {
    "velocity": "joints displace what they move, and a velocity is not a displacement",
    "volume": "no joint changes how large a thing is",
    "distance": "no joint changes how far a thing is from a base, which stands still",
    "count": "no joint changes how many things there are",
    "probability": "no joint moves what is expected",
    "heading_rate": "joints displace what they move, and a rate is not a displacement",
    "extent": "how a thing's outline changes as it turns depends on its shape, which is not known",
    "axis": "how a thing's outline changes as it turns depends on its shape, which is not known",
}

#: Motion of a held object with the hand, between the chains to and from its position.
RIGID_HOLD = Cast("rigid hold", "position", "position", "Eq 3.42", value=False)
#: No turn of a camera changes the size of an object; the length of a hand's opening has a Jacobian.
SIZE_TURN = CAMERA_TURNS[0]._replace(source="length")
SIGHTING = Cast("inverse sighting Jacobian", "heading", "position", "section 3.2.2", value=False)


# The graph has types as nodes and casts as edges. A chain is a path that visits no type twice.
# Breadth-first search yields chains in the order of their length. When the first longer chain is
# dequeued, all chains of minimum length are complete. A set of visited types for all chains would
# lose the second of two equally long chains through one type. A cast of two signals, such as
# triangulation, needs exactly the factors of the start type. It can only come first, because no
# cast produces a product.
@cache
def chains(start: ResourceType, goal: ResourceType) -> tuple[Chain, ...]:
    """Return the shortest chains of casts from one type to another, by breadth-first search.

    A product is cast component by component, unless a cast takes several signals at once.

    Returns:
        All chains of minimum length: one empty chain for equal types, none for unconnected types.
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
