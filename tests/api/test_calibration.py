"""Use of calibrations by runs, and the input that they refuse."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.api.load import load
from cbdsl.api.reading.calibration import read_calibration
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.calibration import CalibratedCamera, CalibrationDocument, CalibrationOrigin
from cbdsl.documents.robot import RobotDocument
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.writer import write
from tests.cli.test_main import cb


def made(folder: Path, robot: str = "dexter", body: int | None = 3) -> Path:
    """Write a calibration file and return its path."""
    camera = CalibratedCamera(
        position=(0.001, 0.0, 0.0),
        rotation=(0.0, 0.0, 0.01),
        position_deviation=0.001,
        rotation_deviation=0.001,
        views=40,
        error_before=3.0,
        error_after=0.2,
    )
    origin = CalibrationOrigin(
        command="cb calibrate dexter", program="show_ball", stage="ball_in_hand", seed=0,
        body=body, backend="bullet",
    )  # fmt: skip
    document = CalibrationDocument(
        cbdsl=1, name="mine", kind="calibration", robot=robot, cameras={"left": camera},
        origin=origin,
    )  # fmt: skip
    file = folder / "mine.yaml"
    write(document, file)
    return file


def test_calibration_corrects_only_its_own_cameras(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = made(tmp_path)
    assert cb(monkeypatch, "validate", str(file)) == 0
    request = load("reachtouch", stage="noisy_right", calibration=str(file), body=3)
    correction = request.robot.cameras["left"].correction
    assert correction is not None and correction.rotation == (0.0, 0.0, 0.01)
    assert request.robot.cameras["right"].correction is None
    assert request.stage.disturbance.body == 3


def test_robots_own_calibration_is_used(dexter: RobotDocument, tmp_path: Path) -> None:
    file = made(tmp_path)
    own = dexter.model_copy(update={"calibration": str(file)})
    found = read_calibration(None, own, file, Library())
    assert found is not None and found.name == "mine"
    assert read_calibration(None, dexter, file, Library()) is None


@pytest.mark.parametrize(
    ("stage", "body", "told"),
    [
        ("noisy_right", None, "other cameras in each episode.*body 3"),
        ("noisy_right", 4, "made with body 3, and this is body 4"),
        ("table_right", 3, "body 3: bodies differ"),
    ],
)
def test_calibrations_of_other_bodies_are_refused(
    stage: str, body: int | None, told: str, tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match=told):
        load("reachtouch", stage=stage, calibration=str(made(tmp_path)), body=body)


def test_calibration_of_another_robot_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = made(tmp_path, robot="sixaxis")
    assert cb(monkeypatch, "run", "reachtouch", "--calibration", str(file)) == 1
    assert "CB375 robot 'sixaxis' has no camera 'left'" in capsys.readouterr().out
