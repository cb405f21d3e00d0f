"""Robot documents proposed from URDF models."""

# Model: a robot document follows from a URDF by these rules.
#     effectors    groups of an SRDF, or else chains of movable joints with a tip
#     start        posture of an SRDF, or else the ready posture: large manipulability, far from
#                  limits, within the efforts (``kinematics.ready_posture``)
#     groups       groups of an SRDF, or else pairs of effectors whose names differ in left and
#                  right, or else similar limbs
#     couplings    mimic joints whose leader is in an effector
#     load_cells   pads of hands, with surfaces and bounded efforts (``scaffold.hand``)
#     no_contact   pairs of an SRDF, and links that touch in all sampled postures or at the start
# The document is a draft for people. It lists omitted joints in comments, with cures if there are
# any. The rules see kinematics and names only.

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from textwrap import TextWrapper
from typing import NamedTuple

from cbdsl.diagnostics.counting import count, some
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.legible_text import legible
from cbdsl.robot.chains import Chain, chains, root
from cbdsl.robot.semantic_groups import SemanticGroup, SemanticGroups
from cbdsl.robot.unsupported_joint import UnsupportedJoint, unsupported, unsupported_joints
from cbdsl.robot.urdf import Mimic, UrdfError, UrdfJoint, UrdfModel
from cbdsl.scaffold.document_template import scalar
from cbdsl.scaffold.hand import DAMPING, FORCE, STIFFNESS, ProposedHand
from cbdsl.scaffold.proposed_effector import (
    between_pads,
    coordinate,
    effector_lines,
    offset_of_tip,
    proposed_postures,
    values_lines,
)
from cbdsl.scaffold.start_contacts import StartContacts, start_contacts

_COMMENT = TextWrapper(
    98,
    initial_indent="# - ",
    subsequent_indent="#   ",
    # Names of joints stay in one piece.
    break_long_words=False,
    break_on_hyphens=False,
)


# Usual margin at the limits, rad or m, and its greatest share of a joint's range.
_MOST_MARGIN = 0.01
_SHARE = 0.05
# Words for a side in the name of an effector, and the minimum number of joints of a limb.
_SIDE = re.compile(r"(?:^|_)(?:left|right|l|r)(?=_|$)", re.IGNORECASE)
_RIGHT = re.compile(r"(?:^|_)(?:right|r)(?=_|$)", re.IGNORECASE)
_LIMB = 3
_UNGROUPED = UnsupportedJoint("in no group of the SRDF", "give them an effector")


class Proposal(NamedTuple):
    """Draft of a robot document.

    Attributes:
        values: Parts of the document, as text for its template.
        left_out: Numbers of omitted joints of the model by reason, as text; may be empty.
        remarks: Sentences on links that touch each other in the start posture.
    """

    values: dict[str, str]
    left_out: str
    remarks: tuple[str, ...] = ()


def propose(model: UrdfModel, folder: Path, semantics: SemanticGroups | None = None) -> Proposal:
    """Return the fields of a robot document that follow from a model.

    Args:
        model: Model of the robot.
        folder: Folder of the document; the path of the model is relative to it.
        semantics: Groups and postures; without them, chains of joints become effectors.

    Raises:
        UsageError: The model has no movable joint.
    """
    limbs = {chain.name: chain for chain in chains(model)} if semantics is None else {}
    effectors = _rows(limbs) if semantics is None else semantics.effectors
    if not effectors:
        grouped = "" if semantics is None else "; the SRDF has no group of joints that they could"
        raise UsageError(_nothing_to_move(model) + grouped)
    joints = sum(len(effector.joints) for effector in effectors.values())
    description = f"A robot with {count(joints, 'joint')} that programs can move."
    idle = _left_out(model, effectors)
    tips = {name: offset_of_tip(model, effector) for name, effector in effectors.items()}
    hands = _hands(model, limbs)
    tips |= dict(between_pads(model, effectors, hands))
    postures = {
        name: dict(each.postures)
        or (hands[name].postures if name in hands else proposed_postures(model, each, tips[name]))
        for name, each in effectors.items()
    }
    # Contacts depend on all effectors together: two arms may touch each other, and not themselves.
    contacts = start_contacts(model, effectors, postures)
    values = {
        "description": scalar(description),
        "model": scalar(Path(os.path.relpath(model.path, folder)).as_posix()),
        "base": scalar(root(model)),
        "effectors": "\n".join(
            effector_lines(
                name,
                each,
                tips[name],
                contacts.postures[name],
                values_lines(model, each, tips[name], hands.get(name)),
            )
            for name, each in effectors.items()
        ),
        "groups": _groups(_alike(effectors) if semantics is None else semantics.groups)
        + _roles(effectors),
        "couplings": _couplings(model, effectors),
        "load_cells": _load_cells(hands),
        "stiffness": _stiffness(hands),
        "force": _force(hands),
        "simulation": _simulation(
            () if semantics is None else semantics.separated, contacts, _materials(model, hands)
        ),
        "left_out": _comment(idle),
        "limit_margin": f"{_margin(effectors):.2g} rad",
    }
    counts = [f"{len(joints)} {_word(why)}" for why, joints in idle.items()]
    return Proposal(values, ", ".join(counts), (*_tip_remarks(limbs), *_remarks(contacts)))


def _rows(limbs: Mapping[str, Chain]) -> dict[str, SemanticGroup]:
    """Return the chains of joints as effectors, for a model without named groups."""
    return {name: SemanticGroup(chain.joints, chain.tip, {}) for name, chain in limbs.items()}


def _hands(model: UrdfModel, limbs: Mapping[str, Chain]) -> dict[str, ProposedHand]:
    """Return the hands that have pads."""
    try:
        hands = {
            n: ProposedHand(model, each.joints) for n, each in limbs.items() if each.tip is None
        }
    except UrdfError:
        return {}  # the document gets a diagnostic for it
    return {name: hand for name, hand in hands.items() if hand.pads}


def _tip_remarks(limbs: Mapping[str, Chain]) -> Iterator[str]:
    """Yield sentences on tips that were chosen among several frames."""
    for name, chain in limbs.items():
        if chain.others:
            yield f"the tip of '{name}' is '{chain.tip}'; there are also {some([*chain.others])}"


def _load_cells(hands: Mapping[str, ProposedHand]) -> str:
    lines = []
    for name, hand in hands.items():
        lines.append(f"  {name}:\n")
        for pad in hand.pads:
            normal = ", ".join(f"{each:g}" for each in pad.normal)
            middle = ", ".join(f"{each:g} m" for each in pad.middle)
            finger = re.sub(r"\W+", "_", pad.link, flags=re.ASCII)
            finger = finger if finger[:1].isalpha() else f"pad_{finger}"
            lines.append(
                f"    {finger}: {{link: {scalar(pad.link)}, joint: {scalar(pad.joint)}, "
                f"normal: [{normal}], pad: [{middle}]}}\n"
            )
    head = "\n# Pads that feel forces, with their directions and middles.\nload_cells:\n"
    return "".join((head, *lines)) if lines else ""


def _force(hands: Mapping[str, ProposedHand]) -> str:
    """Return the settings of controllers of force: the speed is that of the fingers."""
    if not hands:
        return ""
    slides = any(pad.lever == 1.0 for hand in hands.values() for pad in hand.pads)
    speed = "0.05" if slides else "1"
    rest = "{rate: 0.5, window: 0.25 s, within: 0.2}"
    return f"\n    force: {{gain: 4 /s, speed: {speed}, quiescence: {rest}}}"


def _stiffness(hands: Mapping[str, ProposedHand]) -> str:
    """Return the force of a pad per motion of its joint, of two pads in series."""
    levers = [pad.lever for hand in hands.values() for pad in hand.pads if pad.lever < 1.0]
    if not levers:
        return ""
    return f"\n  stiffness: {STIFFNESS / 2 * min(levers):.2g}  # of the pads, N/rad"


def _materials(model: UrdfModel, hands: Mapping[str, ProposedHand]) -> str:
    """Return the surfaces of pads, and efforts of fingers that would crush objects."""
    pads = [pad for hand in hands.values() for pad in hand.pads]
    if not pads:
        return ""
    efforts = {pad.joint: 2 * FORCE * pad.lever for pad in pads}
    strong = {name: most for name, most in efforts.items() if model.joints[name].effort > most}
    lines = [f"    {scalar(name)}: {most:.2g}\n" for name, most in strong.items()]
    if lines:
        lines.insert(0, f"  # Fingers press with at most {FORCE} N.\n  efforts:\n")
    links = ", ".join(scalar(pad.link) for pad in pads)
    surface = f"friction: 1, stiffness: {STIFFNESS}, damping: {DAMPING}, friction_anchor: true"
    return "".join((*lines, f"  surfaces:\n    - {{links: [{links}], {surface}}}\n"))


def _margin(effectors: Mapping[str, SemanticGroup]) -> float:
    """Return the margin of joints at their limits, rad or m: at most 5 % of the smallest range."""
    # A margin of 0.01 m at both ends would block a gripper with a stroke of 2 cm.
    ranges = [j.upper - j.lower for each in effectors.values() for j in each.joints]
    return min(_MOST_MARGIN, _SHARE * min(ranges, default=math.inf))


def _alike(effectors: Mapping[str, SemanticGroup]) -> dict[str, tuple[str, ...]]:
    """Return groups of effectors that differ only in their side, or of all similar limbs."""
    pairs: dict[tuple[str, int], list[str]] = {}
    for name, effector in effectors.items():
        # ``left_arm`` and ``right_arm`` are both of the kind ``arm``, and form the group ``arms``.
        kind = _SIDE.sub("_", name).strip("_")
        if effector.tip is not None and _SIDE.search(name):
            pairs.setdefault((kind, len(effector.joints)), []).append(name)
    # The numbers of joints are equal in each pair, because they are a part of the key.
    groups = {_plural(kind): (*each,) for (kind, _), each in pairs.items() if len(each) == 2}
    if groups:
        return {name: each for name, each in groups.items() if name not in effectors}
    limbs = [name for name, each in effectors.items() if each.tip and len(each.joints) >= _LIMB]
    counts = {len(effectors[name].joints) for name in limbs}
    return {"limbs": (*limbs,)} if len(limbs) > 1 and len(counts) == 1 else {}


def _plural(kind: str) -> str:
    """Return a name for two effectors of a kind; the kind may consist of digits only."""
    return f"{kind}s" if kind[:1].isalpha() else f"both_{kind}".strip("_")


def _groups(groups: Mapping[str, Sequence[str]]) -> str:
    """Return the lines of effector groups that programs can name."""
    lines = [f"  {name}: {{members: [{', '.join(each)}]}}\n" for name, each in groups.items()]
    return (
        "".join(("\n# Effectors that programs can name together.\ngroups:\n", *lines))
        if lines
        else ""
    )


def _roles(effectors: Mapping[str, SemanticGroup]) -> str:
    """Return the lines of the limb that programs for any arm take, if there are several."""
    limbs = {name: each for name, each in effectors.items() if each.tip is not None}
    if len(limbs) < 2:
        return ""

    def rank(name: str) -> tuple[bool, bool, int]:
        is_right = _RIGHT.search(name) is not None
        return "arm" in name.lower(), is_right, len(limbs[name].joints)

    return f"\n# Programs for any arm take this one.\nroles: {{arm: {max(limbs, key=rank)}}}\n"


def _simulation(
    separated: Sequence[tuple[str, str]], contacts: StartContacts, materials: str
) -> str:
    """Return the lines of materials, and of links whose contacts are ignored."""
    known = {frozenset(pair) for pair in separated}
    sections = {
        "as the SRDF says": separated,
        "in every posture that was tried": contacts.always,
        "where it starts": contacts.there,
    }
    lines = []
    for where, pairs in sections.items():
        if pairs is not separated:
            pairs = [pair for pair in pairs if frozenset(pair) not in known]
        if pairs:
            lines += [f"    # {where}\n"]
            lines += [f"    - [{scalar(one)}, {scalar(other)}]\n" for one, other in pairs]
    if lines:
        head = "  # Links whose mutual contacts are ignored, since they touch\n  no_contact:\n"
        lines.insert(0, head)
    return "".join(("\nsimulation:\n", materials, *lines)) if materials or lines else ""


def _remarks(contacts: StartContacts) -> Iterator[str]:
    """Yield sentences on links that touch each other."""
    if contacts.unknown:
        yield f"links that touch each other were not looked for; {contacts.unknown}"
    if contacts.there:
        pairs = [f"{one} and {other}" for one, other in contacts.there]
        yield (
            f"links that touch each other where it starts, but not everywhere: {some(pairs)}; "
            "their contacts are ignored, so a better posture to start from deserves a thought"
        )


def _passive(model: UrdfModel, effectors: Mapping[str, SemanticGroup]) -> dict[str, Mimic]:
    """Return the passive joints that mimic an effector's joint, with their mimic relation."""
    actuated = {joint.name for effector in effectors.values() for joint in effector.joints}
    return {
        joint.name: joint.mimic
        for joint in model.joints.values()
        if joint.movable and joint.mimic is not None and joint.mimic.joint in actuated
    }


def _couplings(model: UrdfModel, effectors: Mapping[str, SemanticGroup]) -> str:
    lines = [
        f"  {scalar(name)}: {{{_coupling(model.joints[name], mimic)}}}\n"
        for name, mimic in _passive(model, effectors).items()
    ]
    return "".join(("\n# Passive joints.\ncouplings:\n", *lines)) if lines else ""


def _coupling(joint: UrdfJoint, mimic: Mimic) -> str:
    offset = f", offset: {coordinate(joint, mimic.offset)}" if mimic.offset else ""
    return f"follows: {scalar(mimic.joint)}, ratio: {mimic.ratio:.7g}{offset}"


def _left_out(
    model: UrdfModel, effectors: Mapping[str, SemanticGroup]
) -> dict[UnsupportedJoint, list[UrdfJoint]]:
    """Return the joints that are in no effector and in no coupling, by reason."""
    named = {joint.name for effector in effectors.values() for joint in effector.joints}
    named.update(_passive(model, effectors))
    others = [joint for name, joint in model.joints.items() if name not in named]
    left_out = unsupported_joints(others)
    ungrouped = [joint for joint in others if unsupported(joint) is None]
    return left_out | ({_UNGROUPED: ungrouped} if ungrouped else {})


def _comment(idle: Mapping[UnsupportedJoint, Sequence[UrdfJoint]]) -> str:
    """Return comment lines that list the omitted joints with the reasons."""
    if not idle:
        return ""
    lines = ["", "# Joints of the model that programs cannot move:"]
    for why, joints in idle.items():
        cure = f" (to move them, {why.cure})" if why.cure else ""
        text = f"{', '.join(legible(joint.name) for joint in joints)}: {why.trait}{cure}"
        lines += _COMMENT.wrap(text)
    return "\n".join(lines) + "\n"


def _nothing_to_move(model: UrdfModel) -> str:
    """Return a sentence on the joints of a model without actuated joints."""
    reasons = []
    for why, joints in unsupported_joints(model.joints.values()).items():
        verb = "is" if len(joints) == 1 else "are"
        cure = f" (to move them, {why.cure})" if why.cure else ""
        reasons.append(f"{len(joints)} {verb} {why.trait}{cure}")
    because = f": {'; '.join(reasons)}" if reasons else ""
    return f"{model.path} has no joint that programs could move{because}"


def _word(why: UnsupportedJoint) -> str:
    """Return the reason why joints are omitted, in a word or two."""
    return why.trait.partition(",")[0]
