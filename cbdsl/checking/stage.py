"""Stage documents against themselves and their robots."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from cbdsl.checking.controller.reach import farthest_tip
from cbdsl.checking.findings import Findings
from cbdsl.checking.lookup.documents import find_document
from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.robot.limits import limit_details
from cbdsl.checking.session import Session
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import (
    BallForm,
    BoxForm,
    Context,
    CylinderForm,
    Fixture,
    PlaceSection,
    StageDocument,
)
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.source_map import Step

_FOR_THINGS = ("place", "motion", "removed_after", "returned_after")


def examine_stage(loaded: Loaded[StageDocument], session: Session, findings: Findings) -> None:
    """Check that a stage names only what there is."""
    name, source = loaded.document.robot, loaded.source
    path = find_document(RobotDocument, name, source.place("robot"), session.library, findings)
    body = session.body(path, findings)
    for node, (first, last) in _reversed_spans(loaded.document, source.root):
        findings.add("CB352", node.place, first=f"{first:g}", last=f"{last:g}")
    for key, context in loaded.document.contexts.items():
        _ContextCheck(loaded, findings, ("contexts", key), context).all(body)
    _names(loaded, findings)
    if body is not None:
        _sizes(loaded, body, findings)


def _sizes(loaded: Loaded[StageDocument], body: CheckedRobot, findings: Findings) -> None:
    """Warn of things that are wider, whichever way they are turned, than any tip can go far."""
    farthest = farthest_tip(body)
    for name, thing in loaded.document.things.items():
        width = _narrowest(thing.form)
        if farthest is not None and width > farthest:
            key = "size" if isinstance(thing.form, BoxForm) else "radius"
            place = loaded.source.place("things", name, "form", key)
            ends = {"width": f"{width:.4g}", "farthest": f"{farthest:.3g}"}
            findings.add("CB721", place, name=name, robot=body.document.name, **ends)


def _narrowest(form: BallForm | BoxForm | CylinderForm) -> float:
    """The least extent of a thing, at its smallest, m."""
    if isinstance(form, BoxForm):
        return min(size[0] for size in form.size)
    across = 2 * form.radius[0]
    return min(across, form.height[0]) if isinstance(form, CylinderForm) else across


def _names(loaded: Loaded[StageDocument], findings: Findings) -> None:
    """Fixtures and things share the world, and things are there to be shown."""
    stage, source = loaded.document, loaded.source
    contexts = stage.contexts.values()
    shown = {name for context in contexts for name in context.things}
    is_forgotten = any(_idle(context) and not context.things for context in contexts)
    are_known = shown.issubset(stage.things) and source.is_whole("contexts")
    for name in stage.things:
        place = source.key("things", name)
        if name in stage.fixtures:
            related = [(source.key("fixtures", name), "the fixture")]
            findings.add("CB354", place, related=related, name=name)
        elif name not in shown and are_known and not is_forgotten:
            findings.add("CB715", place, name=name)


class _ContextCheck:
    def __init__(
        self,
        loaded: Loaded[StageDocument],
        findings: Findings,
        steps: tuple[Step, ...],
        context: Context,
    ) -> None:
        self._stage = loaded.document
        self._source = loaded.source
        self._findings = findings
        self._steps = steps
        self._context = context

    def all(self, body: CheckedRobot | None) -> None:
        context, place = self._context, self._context.place
        for i, name in enumerate(context.things):
            things = self._source.declared(self._stage.things, "things")
            self._known(name, things, "thing of this stage", "things", i)
        if place is not None and place.on is not None:
            fixtures = self._source.declared(self._stage.fixtures, "fixtures")
            self._known(place.on, fixtures, "fixture of this stage", "place", "on")
            self._on_fixture(place, place.on)
        if body is not None:
            self._on_robot(body)
        self._complete()
        self._deeds()

    def _on_robot(self, body: CheckedRobot) -> None:
        place, robot = self._context.place, body.document
        if place is not None and place.hand is not None:
            tips = [name for name, effector in robot.effectors.items() if effector.tip]
            self._known(place.hand, tips, "effector with a tip", "place", "hand")
        joints = [joint for effector in robot.effectors.values() for joint in effector.joints]
        for joint in self._context.joints:
            self._known(joint, joints, "actuated joint", "joints", joint, at_key=True)
        self._within_limits(body)

    def _within_limits(self, body: CheckedRobot) -> None:
        """Joints can start where their context puts them."""
        starts = self._context.joints
        for (joint, span), limits in zip(starts.items(), body.limits(starts), strict=True):
            beyond = [i for i, a in enumerate(span) if limits and not limits[0] <= a <= limits[1]]
            if limits is not None and beyond:
                node = self._source.node((*self._steps, "joints", joint, beyond[0]))
                limits_text = limit_details(node.value, span[beyond[0]], limits)
                self._findings.add("CB355", node.place, joint=joint, **limits_text)

    def _on_fixture(self, place: PlaceSection, name: str) -> None:
        """A thing on a fixture has its centre above it, wherever it is drawn."""
        if place.hand is not None:
            self._lacks("place", "a place on a fixture is in the world, not in reach of a hand")
            return
        fixture = self._stage.fixtures.get(name)
        if fixture is None:
            return
        for axis, span, half in zip("xy", (place.x, place.y), _halves(fixture), strict=True):
            centre = fixture.position["xy".index(axis)]
            # What is computed from centimetres may exceed an edge by a rounding error.
            beyond = [i for i, x in enumerate(span) if abs(x - centre) > half + 1e-9]
            if beyond:
                where = self._source.place(*self._steps, "place", axis, beyond[0])
                ends = {"first": f"{centre - half:.4g}", "last": f"{centre + half:.4g}"}
                details = {"axis": axis, "value": f"{span[beyond[0]]:.4g}", **ends}
                self._findings.add("CB356", where, name=name, **details)

    def _known(
        self, name: str, names: Collection[str], what: str, *steps: Step, at_key: bool = False
    ) -> None:
        if name not in names:
            find = self._source.key if at_key else self._source.place
            place = find(*self._steps, *steps)
            self._findings.add("CB351", place, names=list(names), name=name, what=what)

    def _complete(self) -> None:
        """Keys about a thing need a thing, and the other way round."""
        context, place = self._context, self._context.place
        if context.things and place is None:
            self._lacks("things", "things need a place")
        idle = _idle(context)
        if idle and not context.things:
            verb = "is" if len(idle) == 1 else "are"
            names = " and ".join(idle)
            self._lacks(idle[0], f"{names} {verb} for things, and this context has none")
        is_held = place is not None and place.held
        lacks_place = context.things and place is None
        if context.released_after is not None and not is_held and not lacks_place:
            self._lacks("released_after", "released_after needs a place with `held: true`")

    def _deeds(self) -> None:
        """Actions of the experimenter on a thing happen in an order that is possible."""
        context = self._context
        removed, released = context.removed_after, context.released_after
        is_held = context.place is not None and context.place.held
        if removed is not None and released is not None and removed <= released:
            self._excluded("removed_after", f"it is let go of only after {released:g} s")
        if context.motion is None:
            return
        start = context.motion.after[0]
        if is_held and (released is None or start < released):
            self._excluded("motion", "it is held still when the motion starts")
        if removed is not None and removed <= start:
            self._excluded("removed_after", "it is taken away before its motion starts")

    def _excluded(self, key: str, problem: str) -> None:
        self._findings.add("CB357", self._source.key(*self._steps, key), problem=problem)

    def _lacks(self, key: str, problem: str) -> None:
        self._findings.add("CB353", self._source.key(*self._steps, key), problem=problem)


def _idle(context: Context) -> list[str]:
    """Keys of a context that are about the thing that it shows."""
    return [key for key in _FOR_THINGS if getattr(context, key) is not None]


def _halves(fixture: Fixture) -> tuple[float, float]:
    """Half the largest extent of a fixture along x and y, m."""
    form = fixture.form
    if isinstance(form, BoxForm):
        return form.size[0][1] / 2, form.size[1][1] / 2
    return form.radius[1], form.radius[1]


def _reversed_spans(value: object, node: Node) -> Iterator[tuple[Node, tuple[float, float]]]:
    """The spans in a part of a stage whose upper end is written first."""
    written = node.value
    if isinstance(written, dict):
        for key, child in written.items():
            inner = value[key] if isinstance(value, dict) else getattr(value, key)
            yield from _reversed_spans(inner, child)
    elif isinstance(written, list) and isinstance(value, tuple):
        if len(value) == 2 and isinstance(value[0], float) and value[0] > value[1]:
            yield node, value
        for inner, child in zip(value, written, strict=True):
            yield from _reversed_spans(inner, child)
