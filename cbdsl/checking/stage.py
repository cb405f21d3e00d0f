"""Stage documents against themselves and their robots."""

from __future__ import annotations

from collections.abc import Collection

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
        for part in ("place", "motion", "joints"):
            if self._source.holds(*self._steps, part):
                self._spans(part)

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

    def _spans(self, part: str) -> None:
        written = self._source.node((*self._steps, part))
        model = getattr(self._context, part)
        keys = written.value if isinstance(written.value, dict) else {}
        for key, node in keys.items():
            span = model[key] if isinstance(model, dict) else getattr(model, key)
            if isinstance(span, tuple) and span[0] > span[-1]:
                self._reversed(node, span)

    def _reversed(self, node: Node, span: tuple[float, ...]) -> None:
        details = {"first": f"{span[0]:g}", "last": f"{span[-1]:g}"}
        self._findings.add("CB352", node.place, **details)
