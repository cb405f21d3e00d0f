"""What a URDF model suggests for the document of its robot."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Sequence
from pathlib import Path

from cbdsl.errors.counting import count
from cbdsl.errors.errors import UsageError
from cbdsl.robot.chains import Chain, chains, root
from cbdsl.robot.urdf import UrdfJoint, UrdfModel

# What every YAML takes for a text without quotes, and not for a number, truth or nothing.
_PLAIN = re.compile(
    r"(?!(?:true|false|null|yes|no|on|off|y|n)\Z)[A-Za-z_][\w./-]*\Z", re.ASCII | re.IGNORECASE
)


def propose(model: UrdfModel, folder: Path) -> dict[str, str]:
    """The parts of a robot document, as text for its template.

    Args:
        model: the robot's model.
        folder: where the document will be, to which the path of the model is relative.

    Raises:
        UsageError: the model has no joint that could be moved.
    """
    found = chains(model)
    if not found:
        raise UsageError(f"{model.path} has no revolute joint that turns between limits")
    joints = sum(len(chain.joints) for chain in found)
    description = f"A robot with {count(joints, 'joint')} that programs can move."
    return {
        "description": _scalar(description),
        "model": _scalar(Path(os.path.relpath(model.path, folder)).as_posix()),
        "base": _scalar(root(model)),
        "effectors": "\n".join(_effector(chain) for chain in found),
        "couplings": _couplings(model, found),
    }


def _effector(chain: Chain) -> str:
    angles = ", ".join(f"{_ready(joint):g}" for joint in chain.joints)
    lines = [
        f"{chain.name}:",
        *(f"  # {joint.name}: {_limits(joint)}" for joint in chain.joints),
        f"  joints: [{', '.join(_scalar(joint.name) for joint in chain.joints)}]",
        "  # The frame that has a position and an orientation; its offset is in the link's frame.",
        f"  tip: {{link: {_scalar(chain.tip)}, offset: [0 m, 0 m, 0 m]}}",
        f"  postures: {{ready: [{angles}]}}",
        "  start: ready",
    ]
    return "\n".join(f"  {line}" for line in lines)


def _limits(joint: UrdfJoint) -> str:
    return f"{math.degrees(joint.lower):.0f} to {math.degrees(joint.upper):.0f} deg"


def _ready(joint: UrdfJoint) -> float:
    """Zero where a joint can be there, else the middle of its range; rad."""
    if joint.lower <= 0.0 <= joint.upper:
        return 0.0
    return round((joint.lower + joint.upper) / 2, 4)


def _couplings(model: UrdfModel, found: Sequence[Chain]) -> str:
    """The passive joints that follow one that an effector moves."""
    actuated = {joint.name for chain in found for joint in chain.joints}
    lines = [
        f"  {_scalar(joint.name)}: "
        f"{{follows: {_scalar(joint.mimic.joint)}, ratio: {joint.mimic.ratio:g}}}\n"
        for joint in model.joints.values()
        if joint.revolute and joint.mimic is not None and joint.mimic.joint in actuated
    ]
    return "".join(("\n# Passive joints.\ncouplings:\n", *lines)) if lines else ""


def _scalar(text: str) -> str:
    """A text as YAML; what is valid JSON is."""
    return text if _PLAIN.match(text) else json.dumps(text, ensure_ascii=False)
