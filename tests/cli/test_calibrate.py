"""Commands that make and use calibrations, and the input that they refuse."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from cbdsl.api.reading.calibration import read_calibration
from cbdsl.api.requests.run_request import read_request
from cbdsl.backends.cameras.camera_system import camera_errors
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.calibration import CalibratedCamera, CalibrationDocument, CalibrationOrigin
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.forward import rotation_of
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
    request = read_request("reachtouch", "noisy_right", None, {}, calibration=str(file), body=3)
    correction = request.robot.cameras["left"].correction
    assert correction is not None and correction.rotation == (0.0, 0.0, 0.01)
    assert request.robot.cameras["right"].correction is None
    assert request.stage.disturbance.body == 3


def test_a_robots_own_calibration_is_used(dexter: RobotDocument, tmp_path: Path) -> None:
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
        read_request("reachtouch", stage, None, {}, calibration=str(made(tmp_path)), body=body)


def test_a_calibration_of_another_robot_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = made(tmp_path, robot="desk")
    assert cb(monkeypatch, "run", "reachtouch", "--calibration", str(file)) == 1
    assert "CB375 robot 'desk' has no camera 'left'" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("desk",), "robot 'desk' has no cameras to calibrate"),
        (("dexetr",), "did you mean 'dexter'"),
        (("dexter", "--program", "sixaxis_reach"), "is for robot 'sixaxis'"),
        (("dexter", "--stage", "noisy_right"), "other cameras in each episode; a body's number"),
        (("dexter", "--program", "posture"), "no parameter 'hand'"),
        (("dexter", "--out", "a-b.yaml"), "a calibration is <name>.yaml"),
        (("dexter", "--with", "hand=left_arm"), "left_arm"),
    ],
)
def test_an_impossible_calibration_is_reported(
    arguments: tuple[str, ...],
    told: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cb(monkeypatch, "calibrate", *arguments, "--backend", "kinematic") in (1, 2)
    shown = capsys.readouterr()
    assert told in shown.out + shown.err
    assert not list(tmp_path.rglob("*.yaml"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("backend", "largest"), [("kinematic", (4.0, 0.25)), ("bullet", (2.5, 0.35))]
)
def test_a_body_is_calibrated_by_its_own_hand(
    backend: str,
    largest: tuple[float, float],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    file = tmp_path / "body_7.yaml"
    words = "--body", "7", "--backend", backend, "--out", str(file), "--json"
    assert cb(monkeypatch, "calibrate", "dexter", *words) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["file"] == str(file) and (tmp_path / "body_7.svg").is_file()
    calibration = Library().read(file, CalibrationDocument).document
    disturbance = read_request("show_ball", None, None, {}, body=7).stage.disturbance
    errors = camera_errors(calibration.cameras, disturbance, np.random.default_rng())
    for name, error in errors.items():
        camera = calibration.cameras[name]
        assert 1000 * np.linalg.norm(np.subtract(camera.position, error.position)) < largest[0]
        left = rotation_of(np.array(camera.rotation)).T @ error.rotation
        assert np.rad2deg(np.arccos((np.trace(left) - 1) / 2)) < largest[1]


@pytest.mark.slow
def test_a_killed_calibration_goes_on(tmp_path: Path) -> None:
    """Killed calibrations keep their journal and leave an existing calibration file unchanged."""
    file, journal = made(tmp_path), tmp_path / "mine.jsonl"
    before, words = file.read_bytes(), ["--body", "7", "--backend", "kinematic", "--json"]
    command = [str(Path(sys.executable).with_name("cb")), "calibrate", "dexter", *words, "--out"]
    lines = [0]
    for _ in range(2):
        killed = subprocess.Popen([*command, str(file)], stderr=subprocess.DEVNULL)
        while killed.poll() is None and _lines(journal) < lines[-1] + 6:
            time.sleep(0.002)
        killed.kill()
        killed.wait()
        if not journal.exists():
            break  # the calibration has finished before the signal
        lines.append(_lines(journal))
        assert file.read_bytes() == before
    assert len(lines) > 1 and lines == sorted(lines)
    subprocess.run([*command, str(file)], check=True, capture_output=True)
    assert not journal.exists()
    calibration = Library().read(file, CalibrationDocument).document
    disturbance = read_request("show_ball", None, None, {}, body=7).stage.disturbance
    errors = camera_errors(calibration.cameras, disturbance, np.random.default_rng())
    for name, error in errors.items():
        off = np.subtract(calibration.cameras[name].position, error.position)
        assert 1000 * np.linalg.norm(off) < 4.5


def _lines(journal: Path) -> int:
    return journal.read_bytes().count(b"\n") if journal.exists() else 0
