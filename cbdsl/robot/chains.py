"""Chains: unbranched series of actuated joints that a model suggests as effectors."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import takewhile
from typing import NamedTuple

from cbdsl.robot.tip_frame import acting_link
from cbdsl.robot.unsupported_joint import unsupported
from cbdsl.robot.urdf import UrdfJoint, UrdfModel


# A URDF does not say which joints form an arm, so the tree of joints is divided by a heuristic. A
# chain grows from the root outwards as long as exactly one joint at its last link leads to motion.
# Branches in which nothing moves, such as a fixed camera, do not end it. A joint that programs
# cannot move, such as a mimicking finger, does. Names of joints and links then separate a gripper
# from its arm. The result is only a suggestion: a model with unusual names keeps its gripper in the
# arm.
class Chain(NamedTuple):
    """Series of joints, each mounted on the link of the preceding one.

    Attributes:
        name: Name for programs, distinct among the chains of a model.
        joints: Actuated joints, from the root outwards.
        tip: Acting link, among the links fixed to the last joint's link.
    """

    name: str
    joints: tuple[UrdfJoint, ...]
    tip: str


_Branches = dict[str, list[UrdfJoint]]


def root(model: UrdfModel) -> str:
    """Return the link that no joint moves; the first by name if there are several."""
    return min(model.links - {joint.child for joint in model.joints.values()}, default="")


def chains(model: UrdfModel) -> list[Chain]:
    """Return all chains of a model, from the root outwards.

    They end where several branches move, and before the joints of a gripper.
    """
    branches = _branches(model)
    all_chains = list(_chains(branches, root(model), ()))
    # The only chain of a robot is called an arm even if its joints share no prefix. One or two
    # joints, as of a camera mount, are too few for an arm.
    is_arm = len(all_chains) == 1 and len(all_chains[0].joints) > 2
    named: dict[str, Chain] = {}
    for chain in all_chains:
        whole = chain._replace(name="arm") if is_arm else chain
        for part in _parted(branches, whole, "gripper" if is_arm else f"{chain.name}_gripper"):
            name = _distinct(part.name, named)
            named[name] = part._replace(name=name)
    return list(named.values())


# Patterns for joints that open and close a gripper, by their names or those of the moved links, and
# for joints that turn it as a whole.
_GRIPS = re.compile(r"grip|jaw|claw|finger", re.IGNORECASE)
_JAWS = re.compile(r"jaw|claw|finger", re.IGNORECASE)
_TURNS = re.compile(r"yaw|roll|pitch|wrist|rot", re.IGNORECASE)
# Fewest joints of an arm before its gripper.
_ARM = 3


def _parted(branches: _Branches, chain: Chain, gripper: str) -> Iterator[Chain]:
    """Yield an arm and its gripper separately, or the chain unchanged."""
    tail = list(takewhile(_grips, reversed(chain.joints)))
    arm = chain.joints[: len(chain.joints) - len(tail)]
    # Too few joints precede the gripper on a model that consists of a hand alone; it stays one
    # chain.
    if not tail or len(arm) < _ARM:
        yield chain
        return
    yield Chain(chain.name, arm, acting_link(branches, arm[-1].child))
    yield Chain(gripper, chain.joints[len(arm) :], chain.tip)


def _grips(joint: UrdfJoint) -> bool:
    """Return whether a joint opens and closes a gripper, by the names of its model."""
    # A joint such as gripper_roll turns the gripper as a whole, so it belongs to the arm.
    if _TURNS.search(joint.name):
        return False
    return bool(_GRIPS.search(joint.name) or _JAWS.search(joint.child))


def _branches(model: UrdfModel) -> _Branches:
    """Return the joints by their parent link."""
    branches: _Branches = {}
    for joint in model.joints.values():
        branches.setdefault(joint.parent, []).append(joint)
    return branches


def _chains(
    branches: _Branches, link: str, joints: tuple[UrdfJoint, ...], depth: int = 0
) -> Iterator[Chain]:
    """Yield the chain that has reached a link with some joints, and the chains beyond it."""
    leaving = branches.get(link, []) if depth < _DEEPEST else []
    moving = [joint for joint in leaving if _moves(branches, joint)]
    only = moving[0] if len(moving) == 1 else None
    if only is not None and (only.fixed or _actuated(only)):
        more = (only,) if _actuated(only) else ()
        yield from _chains(branches, only.child, joints + more, depth + 1)
        return
    if joints:
        yield Chain(_name(joints), joints, acting_link(branches, link))
    for joint in moving:
        own = (joint,) if _actuated(joint) else ()
        yield from _chains(branches, joint.child, own, depth + 1)


_DEEPEST = 200  # joints in series; bounds the walk if a model has a loop


def _actuated(joint: UrdfJoint) -> bool:
    return unsupported(joint) is None


def _moves(branches: _Branches, joint: UrdfJoint, depth: int = 0) -> bool:
    """Return whether a joint, or one beyond it, moves."""
    return not joint.fixed or (
        depth < _DEEPEST
        and any(_moves(branches, beyond, depth + 1) for beyond in branches.get(joint.child, []))
    )


def _name(joints: tuple[UrdfJoint, ...]) -> str:
    """Return the common beginning of the names of the joints."""
    names = [joint.name for joint in joints]
    alike = takewhile(lambda letters: len(set(letters)) == 1, zip(*names, strict=False))
    common = "".join(letters[0] for letters in alike)
    name = re.sub(r"\W+", "_", common, flags=re.ASCII).strip("_")
    name = re.sub(r"_?(joint|motor)$", "", name)
    # Nothing is left of joint1 and joint2, and shoulder and elbow have no common beginning.
    return name if re.match(r"[A-Za-z]", name) else "chain"


def _distinct(name: str, taken: dict[str, Chain]) -> str:
    number = 2
    distinct = name
    while distinct in taken:
        distinct, number = f"{name}_{number}", number + 1
    return distinct
