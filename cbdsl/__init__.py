"""Robot behaviour that is declared, type-checked, run and learned: verbs for Python.

The verbs are ``check``, ``load``, ``run``, ``open_robot``, ``learn``, ``explore``,
``explore_pairs`` and ``propose_robot``. Judges use ``evaluate`` and ``simulate``.
They are imported when they are first used, so that ``import cbdsl`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.check import check
    from cbdsl.api.evaluate import SuccessRate, evaluate
    from cbdsl.api.explore import ExplorationOutcome, PairExplorationOutcome, explore, explore_pairs
    from cbdsl.api.learn import LearningOutcome, learn, learn_trials
    from cbdsl.api.load import load
    from cbdsl.api.open_robot import OpenRobot, open_robot
    from cbdsl.api.propose_robot import RobotProposal, propose_robot
    from cbdsl.api.requests.explore_pairs_request import ExplorePairsRequest
    from cbdsl.api.requests.explore_request import ExploreRequest
    from cbdsl.api.requests.learn_request import LearnRequest
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.api.run import run
    from cbdsl.api.simulate import SimulatedRobot, simulate
    from cbdsl.api.simulation.truth import Truth
    from cbdsl.diagnostics.diagnostic import Diagnostic
    from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
    from cbdsl.program.transition import Transition
    from cbdsl.runtime.episode_result import EpisodeResult

#: Module that each public name comes from.
_HOMES = {
    "check": "cbdsl.api.check",
    "load": "cbdsl.api.load",
    "run": "cbdsl.api.run",
    "open_robot": "cbdsl.api.open_robot",
    "learn": "cbdsl.api.learn",
    "learn_trials": "cbdsl.api.learn",
    "explore": "cbdsl.api.explore",
    "explore_pairs": "cbdsl.api.explore",
    "evaluate": "cbdsl.api.evaluate",
    "simulate": "cbdsl.api.simulate",
    "propose_robot": "cbdsl.api.propose_robot",
    "Diagnostic": "cbdsl.diagnostics.diagnostic",
    "DiagnosticsError": "cbdsl.diagnostics.errors",
    "EpisodeResult": "cbdsl.runtime.episode_result",
    "SuccessRate": "cbdsl.api.evaluate",
    "ExplorationOutcome": "cbdsl.api.explore",
    "ExplorePairsRequest": "cbdsl.api.requests.explore_pairs_request",
    "ExploreRequest": "cbdsl.api.requests.explore_request",
    "LearnRequest": "cbdsl.api.requests.learn_request",
    "LearningOutcome": "cbdsl.api.learn",
    "OpenRobot": "cbdsl.api.open_robot",
    "PairExplorationOutcome": "cbdsl.api.explore",
    "RobotProposal": "cbdsl.api.propose_robot",
    "RunRequest": "cbdsl.api.requests.run_request",
    "SimulatedRobot": "cbdsl.api.simulate",
    "Transition": "cbdsl.program.transition",
    "Truth": "cbdsl.api.simulation.truth",
    "UsageError": "cbdsl.diagnostics.errors",
}

__all__ = [  # noqa: RUF022 (verbs before nouns)
    "check", "load", "run", "open_robot", "learn", "learn_trials", "explore", "explore_pairs",
    "evaluate", "simulate", "propose_robot",
    "Diagnostic", "DiagnosticsError", "EpisodeResult", "ExplorationOutcome", "ExplorePairsRequest",
    "ExploreRequest", "LearnRequest", "LearningOutcome", "OpenRobot", "PairExplorationOutcome",
    "RobotProposal", "RunRequest", "SimulatedRobot", "SuccessRate", "Transition", "Truth",
    "UsageError",
]  # fmt: skip


def __getattr__(name: str) -> object:
    """Import a public name when it is first used."""
    if name == "calibrate":
        advice = "cbdsl_calibration.calibrate; try: pip install 'cbdsl[calibration]'"
        raise AttributeError(f"cbdsl.calibrate is {advice}")
    if name not in _HOMES:
        raise AttributeError(f"module 'cbdsl' has no attribute '{name}'")
    value: object = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return all public names, including names not used yet."""
    return sorted({*globals(), *__all__})
