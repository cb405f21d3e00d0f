"""Histories of two seconds, made for the tests of causes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cbdsl.reporting.recorded import Recorded
from cbdsl.runtime.recording import FLAGS, SIGHT
from cbdsl_why.history import History

TICKS = 120
CONTROLLERS = ("reach", "hold", "posture")
_ROBOT = """
<robot name="arm">
  <link name="base"/><link name="upper"/><link name="lower"/><link name="pad"/><link name="nail"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.5 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>
  <joint name="tip" type="fixed"><parent link="lower"/><child link="pad"/>
    <origin xyz="0.5 0 0"/></joint>
  <joint name="side" type="fixed"><parent link="lower"/><child link="nail"/>
    <origin xyz="0.5 0.08 0"/></joint>
</robot>
"""


def flags(name: str, column: int, ticks: slice) -> np.ndarray:
    """Return the flags of controllers, with one set in some ticks."""
    array = np.zeros((TICKS, len(CONTROLLERS)), dtype=np.uint8)
    array[ticks, column] = 1 << FLAGS.index(name)
    return array


def course(value: float, column: int, ticks: slice, usual: float) -> np.ndarray:
    """Return ``usual`` for all controllers, and ``value`` for one of them in some ticks."""
    array = np.full((TICKS, len(CONTROLLERS)), usual, dtype=float)
    array[ticks, column] = value
    return array


def predicates(*parts: tuple[str, int]) -> list[str]:
    """Return the state of each tick from states and their numbers of ticks."""
    return [state for state, ticks in parts for _ in range(ticks)]


def pressed(force: float, lag: float, ticks: slice = slice(60, TICKS)) -> dict[str, Any]:
    """Return loads and references of fingers that press with a force, N, and lag, rad."""
    loads, references = np.zeros((TICKS, 2, 6)), np.zeros((TICKS, 2))
    loads[ticks, :, 2] = force * np.array([1.0, -1.0])
    references[ticks, 1] = lag
    return {"loads": loads, "references": references}


def transition(state: str, action: str, next_state: str, time: float, ticks: int) -> dict[str, Any]:
    """Return a recorded transition of the main program."""
    keys = {"program": "pick", "depth": 0, "reward": 0}
    steps = {"state": state, "action": action, "next_state": next_state}
    return {**keys, **steps, "time": time, "ticks": ticks}


def made(result: dict[str, Any] | None = None, **changes: Any) -> History:
    """Return the history of an arm that reaches to a seen ball, and closes its hand on it.

    Args:
        result: Changes to the recorded result.
        changes: Other parts of the summary, and arrays, with ``__`` for a dot.
    """
    plain = {"potential": "spring", "reference": ""}
    summary: dict[str, Any] = {
        "result": {
            "program": "pick", "stage": "table", "context": "", "seed": 0, "rewarded": False,
            "sim_seconds": 2.0, "ending": "Not rewarded after 2.0 s.", "outcome": "", "causes": {},
            "halted": False, **(result or {}),
        },
        "controllers": list(CONTROLLERS),
        "joints": ["shoulder", "elbow"],
        "load_cells": ["hand.thumb", "hand.finger"],
        "guards": ["hand"],
        "predicates": ["0XX"] * TICKS,
        "transitions": [transition("XXX", "reach", "0XX", 0.0, 1)],
        "members": {"pick": ["reach", "hold"]},
        "limits": {"pick": {"transitions": 40, "transition_time": 10.0}},
        "leads": {"reach": "reach", "hold": "hold"},
        "channels": ["red"],
        "triples": {
            "reach": {**plain, "feedback": "arm.position", "base": "stereo.red", "unit": "m",
                      "effector": "arm.position", "requires": ""},
            "hold": {**plain, "feedback": "hand.finger_forces", "base": "", "unit": "N",
                     "effector": "hand", "requires": ""},
            "posture": {**plain, "feedback": "arm", "base": "arm.ready", "unit": "rad",
                        "effector": "arm", "requires": ""},
        },
        "signals": {
            "arm.position": {"type": "position", "place": True, "channels": []},
            "stereo.red": {"type": "position", "place": True, "channels": ["red"]},
        },
        "robot": {
            "urdf": _ROBOT, "folder": ".", "couplings": {}, "singular_value": 0.04, "lead": 0.12,
            "cells": {"hand.thumb": "pad", "hand.finger": "nail"},
            "tips": {"arm": {"joint": "shoulder", "link": "pad", "offset": [0, 0, 0]}},
        },
    }  # fmt: skip
    ones = np.ones((TICKS, len(CONTROLLERS)))
    arrays: dict[str, Any] = {
        "time": np.arange(TICKS) / 60,
        "positions": np.zeros((TICKS, 2)),
        "references": np.zeros((TICKS, 2)),
        "potentials": ones,
        "errors": 0.1 * ones,
        "flags": flags("stuck", 0, slice(0, 0)),
        "sight": np.full((TICKS, 1), SIGHT.index("seen")),
        "loads": np.zeros((TICKS, 2, 6)),
        "level_priority": (ones * [0, -1, *[1] * (len(CONTROLLERS) - 2)]).astype(int),
        "level_share": ones,
        "level_rank": 3 * ones.astype(int),
        "level_singular_value": ones,
        "level_predicted": ones,
        "level_held_by": -ones.astype(int),
        "at_limits": np.zeros((TICKS, 2), dtype=bool),
        "guard_held": np.zeros((TICKS, 1), dtype=bool),
        "image_time": np.zeros(0),
        "signal_arm.position": np.zeros((TICKS, 3)),
        "signal_stereo.red": np.tile([0.8, 0.1, 0.0], (TICKS, 1)),
    }
    for key, value in changes.items():
        (summary if key in summary else arrays)[key.replace("__", ".")] = value
    return History(Recorded(Path("made.json"), summary, arrays))
