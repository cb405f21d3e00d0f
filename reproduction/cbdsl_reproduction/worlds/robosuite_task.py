"""Tasks of robosuite, the programs for them, and the objects that ideal cameras segment."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

_PROGRAMS = Path(__file__).with_name("programs")


class RobosuiteTask(NamedTuple):
    """Task of robosuite.

    Attributes:
        name: Name of the environment.
        program_name: Name of the program, which is over roles and names no robot.
        middle: Middle of the cameras' view, m, world frame of robosuite.
        features: Bodies or geoms of the task by the colour as which ideal cameras see them.
        least: Least share of successes that is aimed at.
        arms: Number of equal arms.
    """

    name: str
    program_name: str
    middle: tuple[float, float, float]
    features: Mapping[str, tuple[str, ...]]
    least: float
    arms: int = 1

    @property
    def program(self) -> Path:
        """File of the program."""
        return _PROGRAMS / f"{self.program_name}.yaml"


_TABLE = (0.0, 0.0, 0.85)
_BINS = (0.1, 0.0, 0.85)
_PEGS = (0.05, 0.0, 0.85)
_DOOR = (-0.08, -0.25, 1.0)
_BETWEEN = (0.0, -0.25, 0.95)
_ALL = (
    RobosuiteTask("Lift", "lift", _TABLE, {"red": ("cube_main",)}, 0.95),
    RobosuiteTask(
        "Stack", "stack", _TABLE, {"red": ("cubeA_main",), "green": ("cubeB_main",)}, 0.95
    ),
    RobosuiteTask(
        "PickPlaceCan",
        "pick_place",
        _BINS,
        {"red": ("Can_main",), "green": ("VisualCan_main",)},
        0.95,
    ),
    RobosuiteTask(
        "NutAssemblySquare",
        "nut_assembly",
        _PEGS,
        {
            "red": ("SquareNut_g4_visual",),
            "blue": tuple(f"SquareNut_g{side}_visual" for side in range(4)),
            "green": ("peg1",),
        },
        0.9,
    ),
    RobosuiteTask(
        "NutAssemblyRound",
        "nut_assembly",
        _PEGS,
        {
            "red": ("RoundNut_g8_visual",),
            "blue": tuple(f"RoundNut_g{side}_visual" for side in range(8)),
            "green": ("peg2",),
        },
        0.9,
    ),
    RobosuiteTask(
        "Door",
        "door",
        _DOOR,
        {"red": ("Door_handle_visual",), "green": ("Door_handle_base_visual",)},
        0.9,
    ),
    RobosuiteTask(
        "TwoArmLift",
        "lift_with_two",
        _TABLE,
        {"green": ("pot_handle0_c_vis",), "blue": ("pot_handle1_c_vis",)},
        0.9,
        arms=2,
    ),
    RobosuiteTask(
        "TwoArmHandover",
        "hand_over_bar",
        _BETWEEN,
        {
            "red": ("hammer_handle_vis",),
            "blue": tuple(f"hammer_{part}_vis" for part in ("head", "neck", "face", "claw")),
        },
        0.9,
        arms=2,
    ),
)

#: Tasks by name.
TASKS: Mapping[str, RobosuiteTask] = MappingProxyType({task.name: task for task in _ALL})

#: Arms of robosuite with the grippers that it gives them.
ARMS = ("Panda", "Sawyer", "IIWA", "Jaco", "Kinova3", "UR5e", "XArm7")
