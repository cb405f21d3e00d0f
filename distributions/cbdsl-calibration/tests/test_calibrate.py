"""``cb calibrate`` and ``cbdsl_calibration.calibrate``, and the input that they refuse."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from cbdsl.api.load import load
from cbdsl.backends.cameras.camera_system import camera_errors
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.calibration import CalibrationDocument
from cbdsl.kinematics.forward import rotation_of
from cbdsl.yaml_text.library import Library
from cbdsl_calibration import calibrate
from tests.api.test_calibration import made
from tests.cli.test_main import cb


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("sixaxis",), "robot 'sixaxis' has no cameras to calibrate"),
        (("dexetr",), "did you mean 'dexter'"),
        (("dexter", "--stage", "noisy_right"), "other cameras in each episode; a body's number"),
        (("dexter", "--program", "posture"), "no parameter 'hand'"),
        (("dexter", "--out", "a-b.yaml"), "a calibration is <name>.yaml"),
        (("dexter", "--with", "hand=left_arm"), "left_arm"),
    ],
)
def test_impossible_calibration_is_reported(
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
def test_body_is_calibrated_by_its_own_hand(
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
    disturbance = load("show_ball", body=7).stage.disturbance
    errors = camera_errors(calibration.cameras, disturbance, np.random.default_rng())
    for name, error in errors.items():
        camera = calibration.cameras[name]
        assert 1000 * np.linalg.norm(np.subtract(camera.position, error.position)) < largest[0]
        left = rotation_of(np.array(camera.rotation)).T @ error.rotation
        assert np.rad2deg(np.arccos((np.trace(left) - 1) / 2)) < largest[1]


@pytest.mark.slow
def test_killed_calibration_goes_on(tmp_path: Path) -> None:
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
    disturbance = load("show_ball", body=7).stage.disturbance
    errors = camera_errors(calibration.cameras, disturbance, np.random.default_rng())
    for name, error in errors.items():
        off = np.subtract(calibration.cameras[name].position, error.position)
        assert 1000 * np.linalg.norm(off) < 4.5


def _lines(journal: Path) -> int:
    return journal.read_bytes().count(b"\n") if journal.exists() else 0


@pytest.mark.slow
def test_calibrate_writes_a_calibration_that_load_takes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    counts = []
    outcome = calibrate(
        "dexter", out="eyes.yaml", body=3, seed=1,
        backend="kinematic", cameras="ideal", on_progress=lambda *count: counts.append(count),
    )  # fmt: skip
    assert outcome.calibration.exists() and outcome.picture.exists() and counts
    assert outcome.document.origin is not None
    assert outcome.document.origin.command.startswith(
        "cbdsl_calibration.calibrate('dexter', out='eyes.yaml'"
    )
    assert all(each.error_after <= each.error_before for each in outcome.document.cameras.values())


def test_calibrate_rejects_a_file_that_is_no_document(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UsageError, match="a calibration is <name>"):
        calibrate("dexter", out="eyes.txt", backend="kinematic")
    assert not list(tmp_path.iterdir())
