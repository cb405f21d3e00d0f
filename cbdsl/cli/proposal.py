"""A robot document proposed from a URDF model."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import TextWrapper
from typing import NamedTuple

from cbdsl.errors.counting import count
from cbdsl.errors.errors import UsageError
from cbdsl.robot.chains import chains, root
from cbdsl.robot.semantic_groups import SemanticGroup, SemanticGroups
from cbdsl.robot.unsupported_joint import UnsupportedJoint, unsupported, unsupported_joints
from cbdsl.robot.urdf import Mimic, UrdfJoint, UrdfModel

_COMMENT = TextWrapper(
    98,
    initial_indent="# - ",
    subsequent_indent="#   ",
    # Names of joints stay in one piece.
    break_long_words=False,
    break_on_hyphens=False,
)
# What every YAML takes for a text without quotes, and not for a number, truth or nothing.
_PLAIN = re.compile(
    r"(?!(?:true|false|null|yes|no|on|off|y|n)\Z)[A-Za-z_][\w./-]*\Z", re.ASCII | re.IGNORECASE
)


_UNGROUPED = UnsupportedJoint("in no group of the SRDF", "give them an effector")


class Proposal(NamedTuple):
    """A robot document to start from.

    Attributes:
        values: the parts of the document, as text for its template.
        left_out: how many joints of the model it leaves out, by what they are; or nothing.
    """

    values: dict[str, str]
    left_out: str


def propose(model: UrdfModel, folder: Path, semantics: SemanticGroups | None = None) -> Proposal:
    """The fields of a robot document that follow from a model.

    Args:
        model: the robot's model.
        folder: where the document will be, to which the path of the model is relative.
        semantics: its groups and postures; without them rows of joints become effectors.

    Raises:
        UsageError: the model has no joint that could be moved.
    """
    effectors = _rows(model) if semantics is None else semantics.effectors
    if not effectors:
        grouped = "" if semantics is None else "; the SRDF has no group of joints that they could"
        raise UsageError(_nothing_to_move(model) + grouped)
    joints = sum(len(effector.joints) for effector in effectors.values())
    description = f"A robot with {count(joints, 'joint')} that programs can move."
    idle = _left_out(model, effectors)
    values = {
        "description": _scalar(description),
        "model": _scalar(Path(os.path.relpath(model.path, folder)).as_posix()),
        "base": _scalar(root(model)),
        "effectors": "\n".join(_effector(*item) for item in effectors.items()),
        "groups": _groups({} if semantics is None else semantics.groups),
        "couplings": _couplings(model, effectors),
        "simulation": _simulation(() if semantics is None else semantics.separated),
        "left_out": _comment(idle),
    }
    counts = [f"{len(joints)} {_word(why)}" for why, joints in idle.items()]
    return Proposal(values, ", ".join(counts))


def _rows(model: UrdfModel) -> dict[str, SemanticGroup]:
    """Rows of joints, for want of groups that somebody has named."""
    return {chain.name: SemanticGroup(chain.joints, chain.tip, {}) for chain in chains(model)}


_TIP = "  # The frame that has a position and an orientation; its offset is in the link's frame."


def _effector(name: str, effector: SemanticGroup) -> str:
    ready = {"ready": tuple(_ready(joint) for joint in effector.joints)}
    postures = effector.postures or ready
    tip = f"  tip: {{link: {_scalar(effector.tip or '')}, offset: [0 m, 0 m, 0 m]}}"
    lines = [
        f"{name}:",
        *(f"  # {joint.name}: {_limits(joint)}" for joint in effector.joints),
        f"  joints: [{', '.join(_scalar(joint.name) for joint in effector.joints)}]",
        *([] if effector.tip is None else [_TIP, tip]),
        *_postures(postures),
        f"  start: {next(iter(postures))}",
    ]
    return "\n".join(f"  {line}" for line in lines)


def _postures(postures: Mapping[str, Sequence[float]]) -> list[str]:
    texts = [
        f"{_scalar(name)}: [{', '.join(f'{each:.7g}' for each in positions)}]"
        for name, positions in postures.items()
    ]
    if len(texts) == 1:
        return [f"  postures: {{{texts[0]}}}"]
    return ["  postures:", *(f"    {text}" for text in texts)]


def _groups(groups: Mapping[str, Sequence[str]]) -> str:
    """Lines of effectors that programs can name together."""
    lines = [f"  {name}: {{members: [{', '.join(each)}]}}\n" for name, each in groups.items()]
    return (
        "".join(("\n# Effectors that programs can name together.\ngroups:\n", *lines))
        if lines
        else ""
    )


def _simulation(separated: Sequence[tuple[str, str]]) -> str:
    """Lines of links whose contacts are ignored."""
    if not separated:
        return ""
    pairs = "".join(f"    - [{_scalar(one)}, {_scalar(other)}]\n" for one, other in separated)
    return f"\nsimulation:\n  # Links whose mutual contacts are ignored.\n  no_contact:\n{pairs}"


def _limits(joint: UrdfJoint) -> str:
    if joint.endless:
        return "without end"
    if joint.slides:
        return f"{joint.lower:g} to {joint.upper:g} m"
    return f"{math.degrees(joint.lower):.0f} to {math.degrees(joint.upper):.0f} deg"


def _ready(joint: UrdfJoint) -> float:
    """Zero where a joint can be there, else the middle of its range; rad or m."""
    if joint.lower <= 0.0 <= joint.upper:
        return 0.0
    return round((joint.lower + joint.upper) / 2, 4)


def _passive(model: UrdfModel, effectors: Mapping[str, SemanticGroup]) -> dict[str, Mimic]:
    """The passive joints that follow one that an effector moves, and how."""
    actuated = {joint.name for effector in effectors.values() for joint in effector.joints}
    return {
        joint.name: joint.mimic
        for joint in model.joints.values()
        if joint.movable and joint.mimic is not None and joint.mimic.joint in actuated
    }


def _couplings(model: UrdfModel, effectors: Mapping[str, SemanticGroup]) -> str:
    lines = [
        f"  {_scalar(name)}: {{follows: {_scalar(mimic.joint)}, ratio: {mimic.ratio:g}}}\n"
        for name, mimic in _passive(model, effectors).items()
    ]
    return "".join(("\n# Passive joints.\ncouplings:\n", *lines)) if lines else ""


def _left_out(
    model: UrdfModel, effectors: Mapping[str, SemanticGroup]
) -> dict[UnsupportedJoint, list[UrdfJoint]]:
    """The joints that are in no effector and in no coupling, by the reason."""
    named = {joint.name for effector in effectors.values() for joint in effector.joints}
    named.update(_passive(model, effectors))
    others = [joint for name, joint in model.joints.items() if name not in named]
    left_out = unsupported_joints(others)
    ungrouped = [joint for joint in others if unsupported(joint) is None]
    return left_out | ({_UNGROUPED: ungrouped} if ungrouped else {})


def _comment(idle: Mapping[UnsupportedJoint, Sequence[UrdfJoint]]) -> str:
    """Lines that say which joints were left out, and why."""
    if not idle:
        return ""
    lines = ["", "# Joints of the model that programs cannot move:"]
    for why, joints in idle.items():
        cure = f" (to move them, {why.cure})" if why.cure else ""
        text = f"{', '.join(joint.name for joint in joints)}: {why.trait}{cure}"
        lines += _COMMENT.wrap(text)
    return "\n".join(lines) + "\n"


def _nothing_to_move(model: UrdfModel) -> str:
    """A sentence about the joints of a model of which none can be actuated."""
    reasons = []
    for why, joints in unsupported_joints(model.joints.values()).items():
        verb = "is" if len(joints) == 1 else "are"
        cure = f" (to move them, {why.cure})" if why.cure else ""
        reasons.append(f"{len(joints)} {verb} {why.trait}{cure}")
    because = f": {'; '.join(reasons)}" if reasons else ""
    return f"{model.path} has no joint that programs could move{because}"


def _word(why: UnsupportedJoint) -> str:
    """The reason why joints are left out, in a word or two."""
    return why.trait.partition(",")[0]


def _scalar(text: str) -> str:
    """A text as YAML; what is valid JSON is."""
    return text if _PLAIN.match(text) else json.dumps(text, ensure_ascii=False)
