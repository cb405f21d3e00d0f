"""Robot of two shipped Pandas side by side, with two cameras before them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from cbdsl.documents.robot import RobotDocument
from cbdsl.yaml_text.library import Library

SIDES = {"left": 0.4, "right": -0.4}
# Where an arm offers an object to the other one, the turn of its tip then, and its way back.
OFFERS = {
    "left": {"side": "0 cm", "turn": "-69.282 deg", "away": "20 cm"},
    "right": {"side": "0 cm", "turn": "69.282 deg", "away": "-20 cm"},
}
# The giving gripper holds weakly, so that the object slides to the middle between the pads that
# take it; their forces, speed, and distance from the giving gripper.
TAKES = {
    "touch": "4 N", "hold": "4 N", "take": "18 N", "keep": "18 N",
    "soft": "1 cm/s", "meeting": "0 mm",
}  # fmt: skip
# Crosswise grippers do not meet: the pads of one close along the x axis of its tip.
TIP = """
  <link name="right_tip"/>
  <joint name="right_tip_joint" type="fixed">
    <parent link="right_hand"/><child link="right_tip"/>
    <origin xyz="0 0 0" rpy="0 0 1.570796327"/>
  </joint>"""
CAMERA = """
  <link name="{side}_camera"/>
  <joint name="{side}_camera_joint" type="fixed">
    <parent link="stand"/><child link="{side}_camera"/>
    <origin xyz="1.7 {y} 0.9" rpy="0 0.65 {yaw}"/>
  </joint>"""


def write_two_pandas(shipped: Path, folder: Path) -> None:
    """Write the document and the URDF of two Pandas.

    Args:
        shipped: Folder with ``panda.yaml`` and ``panda.urdf``.
        folder: Folder of robots.
    """
    folder.mkdir(parents=True, exist_ok=True)
    urdf = (shipped / "panda.urdf").read_text("utf-8")
    arm = urdf[urdf.index("<link name") : urdf.index('<link name="left_camera">')]
    parts = ['<robot name="two_pandas">\n  <link name="stand"/>']
    for side, y in SIDES.items():
        parts.append(
            f'  <joint name="{side}_base" type="fixed"><parent link="stand"/>'
            f'<child link="{side}_link0"/><origin xyz="0 {y} 0"/></joint>'
        )
        parts.append(re.sub(r"panda_", f"{side}_", arm))
    for side, y, yaw in (("left", -0.2, 2.9), ("right", 0.2, -2.9)):
        parts.append(CAMERA.format(side=side, y=y, yaw=yaw))
    parts.append(TIP)
    (folder / "two_pandas.urdf").write_text("\n".join([*parts, "</robot>\n"]), "utf-8")
    panda: Any = Library().read(shipped / "panda.yaml", RobotDocument).source.root.plain()
    # JSON is YAML.
    (folder / "two_pandas.yaml").write_text(json.dumps(_doubled(panda), indent=1), "utf-8")


def _doubled(panda: dict[str, Any]) -> dict[str, Any]:
    """Return the document of two robots for that of one."""
    double = {
        **panda, "name": "two_pandas", "model": "two_pandas.urdf", "base": "stand",
        "description": "Two arms with parallel grippers, side by side.",
        "roles": {"arm": "right_arm"},
    }  # fmt: skip
    for key in ("effectors", "couplings", "load_cells"):
        double[key] = {
            name.replace("panda", side) if "panda" in name else f"{side}_{name}": _of(side, each)
            for side in SIDES
            for name, each in panda[key].items()
        }
    double["effectors"]["right_arm"]["tip"]["link"] = "right_tip"
    for side in SIDES:
        double["effectors"][f"{side}_arm"]["values"] |= OFFERS[side]
        double["effectors"][f"{side}_hand"]["values"] |= TAKES
    for camera in double["cameras"].values():
        camera["focal_length"] = "210 px"
    simulation = double["simulation"]
    for key in ("surfaces", "no_contact"):
        simulation[key] = [_of(side, each) for side in SIDES for each in simulation[key]]
    simulation["efforts"] = {
        name.replace("panda", side): 2 * effort
        for side in SIDES
        for name, effort in simulation["efforts"].items()
    }
    return double


def _of(side: str, value: Any) -> Any:
    """Return a value of the document with the names of one of both arms."""
    if isinstance(value, str):
        return value.replace("panda", side)
    if isinstance(value, list):
        return [_of(side, each) for each in value]
    return (
        {key: _of(side, each) for key, each in value.items()} if isinstance(value, dict) else value
    )
