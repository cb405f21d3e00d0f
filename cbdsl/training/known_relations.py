"""Names of contacts during an exploration, and the impedance of a pair as a section."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from cbdsl.documents.meta_catalog import ImpedanceSection
from cbdsl.documents.policy import Identity
from cbdsl.learning.catalogs.relation_tree import larger_impedances, name_relation
from cbdsl.learning.impedance import ImpedanceProfile
from cbdsl.types.decision_tree import Tree
from cbdsl.types.direction import DIRECTIONS

# Smallest impedance of a geometric mean, N/m or N m/rad.
_LEAST = 1e-3


class KnownRelations(NamedTuple):
    """Relations document, as an exploration uses it.

    Attributes:
        name: Name of the document.
        tree: Tree that names profiles.
        identity: Name and digest of the document.
    """

    name: str
    tree: Tree[str]
    identity: Identity


def impedance_section(
    profiles: Sequence[ImpedanceProfile], tree: Tree[str] | None
) -> ImpedanceSection:
    """Return the impedance of one pair, with the name that the tree gives most profiles.

    Args:
        profiles: Complete profiles, at least one.
        tree: Tree that names profiles; ``None`` if no relations are known.
    """
    measured = [larger_impedances(profile) for profile in profiles]
    names = Counter(
        name
        for profile in profiles
        if tree is not None and (name := name_relation(tree, profile)) is not None
    )
    return ImpedanceSection(
        profiles=len(profiles),
        tracked={d: sum(profile.tracked()[d] for profile in profiles) for d in DIRECTIONS},
        mean={d: _geometric_mean([each[d] for each in measured]) for d in DIRECTIONS},
        relation=names.most_common(1)[0][0] if names else None,
        names=dict(sorted(names.items())),
    )


def _geometric_mean(values: Sequence[float]) -> float:
    # Impedances differ by orders of magnitude, and the stiffest profile would dominate an
    # arithmetic mean.
    mean = sum(math.log(max(value, _LEAST)) for value in values) / len(values)
    return float(f"{math.exp(mean):.4g}")
