"""Robot behaviour that is declared, type-checked, run and learned: verbs for Python.

``cbdsl.check``, ``load``, ``run``, ``open_robot`` and ``learn`` are imported when they are first
used, so that ``import cbdsl`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.check import check
    from cbdsl.api.learn import LearningOutcome, learn
    from cbdsl.api.load import load
    from cbdsl.api.open_robot import OpenRobot, open_robot
    from cbdsl.api.run import run
    from cbdsl.api.run_request import RunRequest
    from cbdsl.errors.diagnostic import Diagnostic
    from cbdsl.errors.errors import DiagnosticsError, UsageError
    from cbdsl.program.transition import Transition
    from cbdsl.runtime.episode import EpisodeResult

#: Module that each public name comes from.
_HOMES = {
    "check": "cbdsl.api.check",
    "load": "cbdsl.api.load",
    "run": "cbdsl.api.run",
    "open_robot": "cbdsl.api.open_robot",
    "learn": "cbdsl.api.learn",
    "OpenRobot": "cbdsl.api.open_robot",
    "Diagnostic": "cbdsl.errors.diagnostic",
    "DiagnosticsError": "cbdsl.errors.errors",
    "EpisodeResult": "cbdsl.runtime.episode",
    "LearningOutcome": "cbdsl.api.learn",
    "RunRequest": "cbdsl.api.run_request",
    "Transition": "cbdsl.program.transition",
    "UsageError": "cbdsl.errors.errors",
}

__all__ = [  # noqa: RUF022 (verbs before nouns)
    "check", "load", "run", "open_robot", "learn", "OpenRobot", "Diagnostic", "DiagnosticsError",
    "EpisodeResult", "LearningOutcome", "RunRequest", "Transition", "UsageError",
]  # fmt: skip


def __getattr__(name: str) -> object:
    """Import a public name when it is first used."""
    if name not in _HOMES:
        raise AttributeError(f"module 'cbdsl' has no attribute '{name}'")
    value: object = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return all public names, including names not used yet."""
    return sorted({*globals(), *__all__})
