"""Chains of casts as the rows of the signal table execute them (section 3.2.4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from cbdsl.types.casts import Chain
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import chains_of

MANIPULATOR = "inverse manipulator Jacobian"


class CastError(Exception):
    """Chain of casts that no row can execute, which the message names."""


def require_executed(resource: Resource, chains: tuple[Chain, ...]) -> None:
    """Raise an error for chains that the rows of a resource cannot execute.

    Raises:
        CastError: No row of such a source is compiled from one of the chains.
    """
    for chain in chains:
        if chain not in chains_of(resource):
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
