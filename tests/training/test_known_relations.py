"""Impedance of a pair as a section: means, tracked loads and names."""

from __future__ import annotations

import pytest

from cbdsl.training.known_relations import impedance_section
from cbdsl.types.decision_tree import Leaf, Split
from tests.learning.profiles import FLAT, ROUND

TREE = Split("dRz", 0.05, Leaf("plane_on_plane"), Leaf("spherical"))


def test_impedance_section_counts_names_and_loads_and_averages_logarithms() -> None:
    section = impedance_section([ROUND, FLAT, FLAT], TREE)
    assert (section.relation, section.names) == (
        "plane_on_plane",
        {"plane_on_plane": 2, "spherical": 1},
    )
    assert section.tracked["dPz"] == 3 and section.tracked["dPx"] == 0
    assert section.mean["dPz"] == pytest.approx(4000.0)
    assert section.mean["dRz"] == pytest.approx((0.01 * 0.2 * 0.2) ** (1 / 3), rel=1e-3)


def test_impedance_section_without_relations_has_no_name() -> None:
    assert impedance_section([ROUND], None).relation is None
