"""Stage documents against themselves and their robots."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from cbdsl.checking.findings import Findings
from cbdsl.checking.session import Session
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Context, StageDocument
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.reader import Loaded
from cbdsl.yaml_text.source_map import Step


def examine_stage(loaded: Loaded[StageDocument], session: Session, findings: Findings) -> None:
    """Check that a stage names only what there is."""
    name, source = loaded.document.robot, loaded.source
    path = session.library.find(RobotDocument, name, loaded.path)
    if path is None:
        names = session.library.names(RobotDocument, loaded.path)
        findings.add("CB601", source.place("robot"), names=names, name=name)
        robot = None
    else:
        robot = session.body(path, findings).document
    for node, (first, last) in _reversed_spans(loaded.document, source.root):
        findings.add("CB352", node.place, first=f"{first:g}", last=f"{last:g}")
    for key, context in loaded.document.contexts.items():
        _ContextCheck(loaded, findings, ("contexts", key), context).all(robot)


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

    def all(self, robot: RobotDocument | None) -> None:
        context, place = self._context, self._context.place
        for i, name in enumerate(context.things):
            self._known(name, self._stage.things, "thing of this stage", "things", i)
        if place is not None and place.on is not None:
            self._known(place.on, self._stage.fixtures, "fixture of this stage", "place", "on")
        if robot is not None:
            self._on_robot(robot)
        self._complete()

    def _on_robot(self, robot: RobotDocument) -> None:
        place = self._context.place
        if place is not None and place.hand is not None:
            tips = [name for name, effector in robot.effectors.items() if effector.tip]
            self._known(place.hand, tips, "effector with a tip", "place", "hand")
        joints = [joint for effector in robot.effectors.values() for joint in effector.joints]
        for joint in self._context.joints:
            self._known(joint, joints, "actuated joint", "joints", joint, at_key=True)

    def _known(
        self, name: str, names: Collection[str], what: str, *steps: Step, at_key: bool = False
    ) -> None:
        if name not in names:
            find = self._source.key if at_key else self._source.place
            place = find(*self._steps, *steps)
            self._findings.add("CB351", place, names=list(names), name=name, what=what)

    def _complete(self) -> None:
        """What is said of a thing needs a thing, and the other way round."""
        context, place = self._context, self._context.place
        if context.things and place is None:
            self._lacks("things", "things need a place")
        for key in ("place", "motion", "removed_after"):
            if getattr(context, key) is not None and not context.things:
                self._lacks(key, f"{key} is for things, and this context has none")
        if context.released_after is not None and not (place is not None and place.held):
            self._lacks("released_after", "released_after needs a place with `held: true`")

    def _lacks(self, key: str, problem: str) -> None:
        self._findings.add("CB353", self._source.key(*self._steps, key), problem=problem)


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
