"""Sensors of another package's kind: readings fit their row, or the package is named."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cbdsl.api.shipped import shipped_robot
from cbdsl.documents.robot import Sensor as Section
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.source_kind import SOURCES, SourceKind
from cbdsl.sensing.declared_signal import declared_reader
from cbdsl.sensing.sensor_faults import SensorError
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading
from cbdsl.types.registry import PluginError
from cbdsl.types.resource_type import HEADING, ORIENTATION

JOINTS = 4
PAIR = HEADING
Sensor = Callable[[], Reading | None]

#: Reading that the package's function returns for a signal.
made: Callable[[Any, Any], Sensor]


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Reading | None]:
    """Return a function that reads two numbers from a sensor's value."""
    kind = SimpleNamespace(reader=f"{__name__}:made")
    monkeypatch.setattr(SOURCES, "get", lambda name: kind)
    monkeypatch.setattr(SOURCES, "fault", lambda name, reason: PluginError(f"{name}: {reason}"))

    def make(sensor: Sensor, signals: object = None) -> Reading | None:
        signal = SimpleNamespace(kind="wrist", sensor="left")

        def build(asked: object, given: object) -> Sensor:
            assert asked is signal and given is signals
            return sensor

        monkeypatch.setitem(globals(), "made", build)
        return declared_reader(signal, PAIR, JOINTS, signals)()  # type: ignore[arg-type]

    return make


@pytest.mark.parametrize("jacobian", [None, np.ones((2, JOINTS))])
def test_suitable_reading_is_returned_unchanged(
    read: Callable[..., Reading | None], jacobian: np.ndarray | None
) -> None:
    reading = Reading(np.array([1.0, 2.0]), jacobian, 3)
    assert read(lambda: reading, object()) is reading
    assert read(lambda: None) is None


def test_orientation_is_read_as_a_matrix(monkeypatch: pytest.MonkeyPatch) -> None:
    kind = SourceKind("aim", "an aim", {"axes": ORIENTATION}, f"{__name__}:made", needs=())
    monkeypatch.setattr(SOURCES, "get", lambda name: kind)
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    robot, urdf = shipped_robot("panda")
    kinematics = Kinematics(robot, urdf)
    jacobian = np.zeros((3, len(kinematics.joints)))
    reader = Reading(turned, jacobian, 1)
    monkeypatch.setitem(globals(), "made", lambda signal, signals: lambda: reader)
    (resource,) = kind.resources("aim", Section(kind="aim"), robot)
    signals = Signals(robot, kinematics, [resource])
    row = signals.bind(resource)
    reading = signals.reading(row, resource.type.name)
    assert reading is not None and reading.jacobian is not None
    np.testing.assert_array_equal(reading.value, turned)
    assert reading.jacobian.shape == jacobian.shape


@pytest.mark.parametrize(
    ("reading", "fault"),
    [
        (Reading(np.zeros(3), None, 0), r"value has shape \(3,\), not \(2,\)"),
        (Reading(np.zeros((2, 1)), None, 0), r"value has shape \(2, 1\)"),
        (Reading(np.zeros(2), np.zeros((2, 3)), 0), r"Jacobian has shape \(2, 3\), not \(2, 4\)"),
        (Reading(np.zeros(2), np.zeros((3, JOINTS)), 0), r"Jacobian has shape \(3, 4\)"),
    ],
)
def test_unsuitable_reading_names_the_package(
    read: Callable[..., Reading | None], reading: Reading, fault: str
) -> None:
    with pytest.raises(PluginError, match=f"wrist: ValueError: its {fault}"):
        read(lambda: reading)


def test_a_number_that_is_not_finite_is_the_sensors(read: Callable[..., Reading | None]) -> None:
    for bad in (np.nan, np.inf):
        with pytest.raises(SensorError, match="the sensor left is not finite"):
            read(lambda bad=bad: Reading(np.array([0.0, bad]), None, 0))


def test_exception_of_a_reader_names_the_package(
    read: Callable[..., Reading | None], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken() -> Reading:
        raise KeyError("no wire")

    with pytest.raises(PluginError, match="wrist: KeyError: 'no wire'"):
        read(broken)
    with pytest.raises(PluginError, match="wrist: TypeError"):
        monkeypatch.setitem(globals(), "made", None)
        declared_reader(SimpleNamespace(kind="wrist", sensor="left"), PAIR, JOINTS, None)  # type: ignore[arg-type]
