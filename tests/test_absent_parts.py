"""Failures that are due to absent parts."""

from __future__ import annotations

import pytest

from tests import absent_parts
from tests.absent_parts import absent_part


def test_absent_part_is_found_only_in_failures_that_name_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(absent_parts, "MESSAGES", ("No module named 'pybullet",))
    assert absent_part("E   ModuleNotFoundError: No module named 'pybullet_data'")
    assert absent_part("E   assert 1 == 2") is None
    assert absent_part("E   ModuleNotFoundError: No module named 'cbdsl.absent'") is None


def test_absent_parts_of_a_machine_with_all_engines_are_none() -> None:
    bullet = pytest.importorskip("pybullet")
    assert bullet and not any("bullet" in message for message in absent_parts.MESSAGES)
