"""Simulation: missing packages are reported with the extra that installs them."""

from __future__ import annotations

import pytest

from cbdsl.backends.engines import extra_advice
from cbdsl.cli.episodes.simulation import needing_simulation
from cbdsl.diagnostics.errors import UsageError


@pytest.mark.parametrize(
    ("module", "extra"),
    [("cyclonedds", "ros2"), ("cyclonedds.core", "ros2"), ("pinocchio", "sim"), ("mujoco", "sim")],
)
def test_missing_package_is_reported_with_its_extra(module: str, extra: str) -> None:
    with pytest.raises(UsageError) as raised, needing_simulation():
        raise ModuleNotFoundError(f"No module named '{module}'", name=module)
    expected = f"running needs {module}, which is not installed: {extra_advice(extra)}"
    assert str(raised.value) == expected
