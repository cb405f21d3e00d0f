"""Installed engines, and the default engine."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib.util import find_spec

#: Module that each engine of this project requires, in the order of preference.
MODULES: Mapping[str, str] = {
    "bullet": "pybullet",
    "mujoco": "cbdsl_mujoco",
    "kinematic": "pinocchio",
}

# First version of Python for which a package of the extra has no wheels.
_NO_WHEELS = {"bullet": (3, 14), "ros2": (3, 14)}


def installed_engines() -> tuple[str, ...]:
    """Return the names of the installed engines; none of them is imported."""
    # Only the presence is checked, because an import would slow down each command.
    return tuple(name for name, module in MODULES.items() if find_spec(module) is not None)


def default_engine() -> str:
    """Return the engine of a command without ``--backend``: the first that is installed."""
    return next(iter(installed_engines()), "kinematic")


def remedy(name: str) -> str:
    """Return the advice for an engine that is not installed.

    Args:
        name: Engine of cbdsl's own.
    """
    return f"{extra_advice(name)}; installed: {', '.join(installed_engines()) or 'none'}"


def extra_advice(extra: str) -> str:
    """Return how to install an extra, or why it cannot be installed.

    Args:
        extra: Extra that is named after an engine or a kind of driver.
    """
    limit = _NO_WHEELS.get(extra)
    if limit is not None and sys.version_info >= limit:
        return f"it has no wheels for Python {'.'.join(map(str, sys.version_info[:2]))}"
    return f"try: pip install 'cbdsl[{extra}]'"
