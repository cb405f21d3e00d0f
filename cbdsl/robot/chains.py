"""Chains: unbranched series of actuated joints that a model suggests as effectors."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import takewhile
from typing import NamedTuple

from cbdsl.robot.tip_frame import acting_links
from cbdsl.robot.unsupported_joint import unsupported
from cbdsl.robot.urdf import UrdfJoint, UrdfModel


# A URDF does not say which joints form an arm, so the tree of joints is divided by a heuristic. A
# chain grows from the root outwards as long as exactly one joint at its last link leads to motion.
# Branches in which nothing moves, such as a fixed camera, do not end it. A joint that programs
# cannot move, such as a mimicking finger, does. Names of joints and links then separate a gripper
# from its arm, join the fingers of a hand, and name limbs. The result is only a suggestion: a model
# with unusual names keeps its gripper in the arm.
class Chain(NamedTuple):
    """Series of joints, each mounted on the link of the preceding one, or the fingers of a hand.

    Attributes:
        name: Name for programs, distinct among the chains of a model.
        joints: Actuated joints, from the root outwards.
        tip: Acting link, among the links fixed to the last joint's link; ``None`` for a hand.
        others: Other links with usual names of acting frames there.
    """

    name: str
    joints: tuple[UrdfJoint, ...]
    tip: str | None
    others: tuple[str, ...] = ()


_Branches = dict[str, list[UrdfJoint]]


def root(model: UrdfModel) -> str:
    """Return the link that no joint moves; the first by name if there are several."""
    return min(model.links - {joint.child for joint in model.joints.values()}, default="")


def chains(model: UrdfModel) -> list[Chain]:
    """Return all chains of a model, from the root outwards.

    They end where several branches move, and before the joints of a gripper. All fingers on one
    limb are one hand.
    """
    branches = _branches(model)
    moving = _leading_to_motion(model)
    parts = [
        part
        for chain in _chains(branches, moving, root(model), ())
        for part in _parted(branches, chain)
    ]
    parts = _joined(model, parts)
    limbs = [part for part in parts if part.tip is not None]
    # The only limb of a robot is an arm, also without such words. One or two joints, as of a camera
    # mount, are too few for an arm.
    only = limbs[0] if len(limbs) == 1 and len(limbs[0].joints) >= _ARM else None
    names = ["arm" if part is only else _limb(part) for part in parts]
    if only is not None and len(parts) == 2:
        names = ["arm" if part is only else "hand" for part in parts]
    named: dict[str, Chain] = {}
    for part, limb in zip(parts, names, strict=True):
        # Limbs that would share a name, such as four legs, keep the common part of joint names.
        name = _distinct(limb if limb and names.count(limb) == 1 else part.name, named)
        named[name] = part._replace(name=name)
    return list(named.values())


def _joined(model: UrdfModel, parts: list[Chain]) -> list[Chain]:
    """Return the chains, with the fingers that one limb carries joined to a hand."""
    fingers = {joint.name for part in parts if _is_finger(part) for joint in part.joints}
    hands: dict[str, Chain] = {}
    joined: list[Chain] = []
    for part in parts:
        if not _is_finger(part):
            joined.append(part)
            continue
        above = model.above(part.joints[0].child)
        mount = next((name for name in above if name not in fingers), "")
        if mount not in hands:
            joined.append(part)  # in the place of the first finger
        hand = hands.get(mount, part._replace(joints=()))
        hands[mount] = hand._replace(joints=hand.joints + part.joints, tip=None, others=())
    whole = {hand.joints[0].name: hand for hand in hands.values()}
    return [whole.get(part.joints[0].name, part) for part in joined]


def _is_finger(chain: Chain) -> bool:
    return all(_grips(joint) for joint in chain.joints)


# Words in the names of joints and links by which limbs are recognised, and their sides.
_KINDS = {
    "hand": ("finger", "gripper", "thumb", "jaw", "claw", "knuckle", "hand"),
    "head": ("head", "neck"),
    "leg": ("leg", "hip", "knee", "ankle", "thigh", "calf", "shank", "foot"),
    "torso": ("torso", "waist", "spine"),
    "arm": ("arm", "shoulder", "elbow", "wrist", "forearm", "uarm"),
}
_SIDES = {"left": "left", "l": "left", "right": "right", "r": "right"}
_WORDS = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+")
# Fewest joints of a limb without a known word that counts as an arm.
_ANY_ARM = 6


def _limb(chain: Chain) -> str:
    """Return a name such as ``left_arm`` by the words of a chain's joints; empty if unknown."""
    joints = [_words(joint.name) for joint in chain.joints]
    side = next((_SIDES[word] for word in joints[0] if word in _SIDES), "")
    if side and not all(any(_SIDES.get(word) == side for word in words) for words in joints):
        return ""
    if chain.tip is None:
        kind = "hand"
    else:
        counts = {
            kind: sum(any(word in known for word in words) for words in joints)
            for kind, known in _KINDS.items()
            if kind != "hand"
        }
        kind = max(counts, key=lambda each: counts[each])
        if not counts[kind]:
            kind = "arm" if side and len(joints) >= _ANY_ARM else ""
    return "_".join(filter(None, (side, kind))) if kind else ""


def _words(name: str) -> list[str]:
    return [word.lower() for word in _WORDS.findall(name)]


# Patterns for joints that open and close a gripper, by their names or those of the moved links, and
# for joints that turn it as a whole.
_GRIPS = re.compile(
    r"grip|jaw|claw|finger|thumb|knuckle|hand_(index|middle|mrl|ring|little)", re.IGNORECASE
)
_JAWS = re.compile(r"jaw|claw|finger|thumb|knuckle", re.IGNORECASE)
_TURNS = re.compile(r"yaw|roll|pitch|wrist|rot", re.IGNORECASE)
# Fewest joints of an arm before its gripper.
_ARM = 3


def _parted(branches: _Branches, chain: Chain) -> Iterator[Chain]:
    """Yield an arm and its gripper separately, or the chain unchanged."""
    tail = list(takewhile(_grips, reversed(chain.joints)))
    arm = chain.joints[: len(chain.joints) - len(tail)]
    # Too few joints precede the gripper on a model that consists of a hand alone; it stays one
    # chain.
    if not tail or len(arm) < _ARM:
        yield chain
        return
    yield Chain(chain.name, arm, *acting_links(branches, arm[-1].child))
    yield Chain(f"{chain.name}_gripper", chain.joints[len(arm) :], chain.tip)


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
    branches: _Branches,
    leading: frozenset[str],
    link: str,
    joints: tuple[UrdfJoint, ...],
    depth: int = 0,
) -> Iterator[Chain]:
    """Yield the chain that has reached a link with some joints, and the chains beyond it."""
    leaving = branches.get(link, []) if depth < _DEEPEST else []
    moving = [joint for joint in leaving if joint.name in leading]
    only = moving[0] if len(moving) == 1 else None
    if only is not None and (only.fixed or _actuated(only)):
        more = (only,) if _actuated(only) else ()
        yield from _chains(branches, leading, only.child, joints + more, depth + 1)
        return
    if joints:
        yield Chain(_name(joints), joints, *acting_links(branches, joints[-1].child, link))
    for joint in moving:
        own = (joint,) if _actuated(joint) else ()
        yield from _chains(branches, leading, joint.child, own, depth + 1)


_DEEPEST = 200  # joints in series; bounds the walk if a model has a loop


def _actuated(joint: UrdfJoint) -> bool:
    return unsupported(joint) is None


def _leading_to_motion(model: UrdfModel) -> frozenset[str]:
    """Return the joints that move, or carry one that moves."""
    leading: set[str] = set()
    for joint in model.joints.values():
        if joint.fixed:
            continue
        # The way upwards ends where another moving joint has already passed.
        for above in model.way(joint.child):
            if above.name in leading:
                break
            leading.add(above.name)
    return frozenset(leading)


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
