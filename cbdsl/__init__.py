"""Robot behaviour that is declared, type-checked, run and learned: verbs for Python.

``cbdsl.check``, ``load``, ``run``, ``open_body`` and ``learn`` are imported when they are first
used, so that ``import cbdsl`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.body import Body, open_body
    from cbdsl.api.check import check
    from cbdsl.api.learn import Learned, learn
    from cbdsl.api.load import load
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
    "open_body": "cbdsl.api.body",
    "learn": "cbdsl.api.learn",
    "Body": "cbdsl.api.body",
    "Diagnostic": "cbdsl.errors.diagnostic",
    "DiagnosticsError": "cbdsl.errors.errors",
    "EpisodeResult": "cbdsl.runtime.episode",
    "Learned": "cbdsl.api.learn",
    "RunRequest": "cbdsl.api.run_request",
    "Transition": "cbdsl.program.transition",
    "UsageError": "cbdsl.errors.errors",
}

__all__ = [  # noqa: RUF022 (verbs before nouns)
    "check", "load", "run", "open_body", "learn", "Body", "Diagnostic", "DiagnosticsError",
    "EpisodeResult", "Learned", "RunRequest", "Transition", "UsageError",
]  # fmt: skip


def __getattr__(name: str) -> object:
    """A public name, imported when it is first used."""
    if name not in _HOMES:
        raise AttributeError(f"module 'cbdsl' has no attribute '{name}'")
    found: object = getattr(import_module(_HOMES[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """The public names, whether or not they were used."""
    return sorted({*globals(), *__all__})
