"""Names in a robot's document that already have another meaning."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.channel_names import bin_names
from cbdsl.robot.resources import CAMERAS, STEREO
from cbdsl.types.resource import CYCLOPEAN
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step

Steps = tuple[Step, ...]

_SIGHT = {CAMERAS: "all cameras", CYCLOPEAN: "the mean of all cameras", STEREO: "both cameras"}
_TIP = ("position", "orientation", "pose")


def check_names(loaded: Loaded[RobotDocument], diagnostics: Diagnostics) -> None:
    """Report names that already have another meaning in programs."""
    robot, source = loaded.document, loaded.source
    for steps, meaning in _taken(robot):
        diagnostics.add("CB314", source.key(*steps), name=steps[-1], meaning=meaning)
    channels = robot.vision.channels
    bins = {*bin_names(channels)}
    for key, names, taken in (
        ("colors", channels.colors, bins),
        ("aliases", channels.aliases, bins | {*channels.colors}),
    ):
        for name in names:
            if name in taken:
                diagnostics.add("CB315", source.key("vision", "channels", key, name), name=name)


def _taken(robot: RobotDocument) -> Iterator[tuple[Steps, str]]:
    """Yield the paths of keys with names that are taken, and the meaning of each name."""
    cameras = {name: f"camera '{name}'" for name in robot.cameras}
    sight = {**cameras, **_SIGHT} if robot.cameras else {}
    yield from ((("cameras", name), _SIGHT[name]) for name in robot.cameras if name in _SIGHT)
    for section in ("effectors", "groups"):
        names = getattr(robot, section)
        yield from (((section, name), sight[name]) for name in names if name in sight)
    for name, effector in robot.effectors.items():
        parts = {"uniform": "a draw between the joint limits"}
        if effector.tip is not None:
            parts |= {part: f"the {part} of its tip" for part in _TIP}
        if name in robot.load_cells:
            parts |= {"finger_forces": "the forces of its fingers"}
        for posture in effector.postures:
            if posture in parts:
                yield ("effectors", name, "postures", posture), parts[posture]
    for hand, cells in robot.load_cells.items():
        if "net" in cells:
            yield ("load_cells", hand, "net"), "the sum over the fingers"
