"""Kinds of sensors: typed signals from a declaration, and entries that are refused."""

from __future__ import annotations

import pytest

from cbdsl.documents.robot import RobotDocument, Sensor
from cbdsl.robot.source_kind import SOURCES, SourceKind
from cbdsl.types.registry import PluginError
from cbdsl.types.resource import Origin, SensorSignal
from cbdsl.types.resource_type import FORCE, LENGTH, TORQUE

KIND = SourceKind("scale", "weight", {"force": FORCE, "torque": TORQUE}, "scale:reader")
AT_LINK = Sensor(kind="scale", link="right_palm")
OF_HAND = Sensor(kind="scale", hand="right_hand", options={"rays": 2})


def test_resources_of_a_sensor_have_the_declared_types(dexter: RobotDocument) -> None:
    force, torque = KIND.resources("wrist", AT_LINK, dexter)
    assert (force.name, force.type, torque.name, torque.type) == (
        "wrist.force", FORCE, "wrist.torque", TORQUE,
    )  # fmt: skip
    assert force.source == SensorSignal("wrist", "scale", "force", ("right_palm",))
    assert force.origin is Origin.ENVIRONMENT


@pytest.mark.parametrize("needs", [("link",), ("hand", "link")])
def test_resources_of_a_sensor_without_a_needed_key_are_none(
    dexter: RobotDocument, needs: tuple[str, ...]
) -> None:
    assert not list(KIND._replace(needs=needs).resources("wrist", OF_HAND, dexter))


def test_resources_of_a_sensor_without_link_depend_on_its_hand(dexter: RobotDocument) -> None:
    (first, _) = KIND._replace(needs=("hand",)).resources("wrist", OF_HAND, dexter)
    cells = dexter.load_cells["right_hand"].values()
    assert first.source[-1] == tuple(cell.link for cell in cells)


def test_resources_follow_a_function_of_the_section(dexter: RobotDocument) -> None:
    def rays(sensor: Sensor, robot: RobotDocument) -> dict[str, object]:
        return {f"ray_{ray}": LENGTH for ray in range(int(sensor.options["rays"]))}

    kind = KIND._replace(signals=rays, needs=("options",), origin=Origin.KINEMATICS)  # type: ignore[arg-type]
    found = list(kind.resources("lidar", OF_HAND, dexter))
    assert [each.name for each in found] == ["lidar.ray_0", "lidar.ray_1"]
    assert {each.origin for each in found} == {Origin.KINEMATICS}


@pytest.mark.parametrize(
    ("entry", "reason"),
    [
        (KIND._replace(name="other"), "calls itself 'other'"),
        (KIND._replace(reader="scale"), "read by 'scale'"),
        (KIND._replace(signals={"force": "force"}), "neither types by name nor a function"),  # type: ignore[dict-item]
        (KIND._replace(signals=3), "neither types by name nor a function"),  # type: ignore[arg-type]
        (KIND._replace(needs=("lnik",)), "needs lnik; keys of a sensor: link, hand, options"),
        (object(), "is a object, not a SourceKind"),
    ],
)
def test_faulty_kind_is_refused_with_the_reason(entry: object, reason: str) -> None:
    with pytest.raises(PluginError, match=reason):
        SOURCES._validate("scale", entry)
