"""Judge of tasks of robosuite: its process, its cameras, its programs, and an episode."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl import UsageError, load
from cbdsl.extend.backend import BackendError, read_robot
from cbdsl_reproduction.judges.judge import BodyChoice
from cbdsl_reproduction.judges.robosuite import JUDGE
from cbdsl_reproduction.worlds import robosuite_process
from cbdsl_reproduction.worlds.camera_pair import looking_at
from cbdsl_reproduction.worlds.edge_sensor import EDGES
from cbdsl_reproduction.worlds.robosuite_backend import (
    RobosuiteBackend,
    filled,
    stroke_share,
)
from cbdsl_reproduction.worlds.robosuite_process import robosuite_python
from cbdsl_reproduction.worlds.robosuite_task import ARMS, TASKS
from tests.cli import test_main
from tests.conftest import ROOT

PROGRAMS = sorted(next(iter(TASKS.values())).program.parent.glob("*.yaml"))
coordinate = st.floats(-1.0, 1.0)


def missing_environment() -> str:
    """Return why no environment of robosuite can be used; empty if one can."""
    try:
        robosuite_python()
    except BackendError as error:
        return str(error)
    return ""


def cb(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Run ``cb judge robosuite`` in this process and return its exit code."""
    return test_main.cb(monkeypatch, "judge", "robosuite", *arguments)


def test_robosuite_judge_without_environment_names_the_command(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv(robosuite_process.VARIABLE, str(tmp_path / "python"))
    assert cb(monkeypatch, "--task", "Lift", "--arm", "Panda", "--episodes", "1") == 2
    problem = capsys.readouterr().err
    assert str(tmp_path / "python") in problem
    assert "`make robosuite`" in problem


@pytest.mark.parametrize(("option", "known"), [("--task", TASKS), ("--arm", ARMS)])
def test_robosuite_judge_with_unknown_part_names_the_known_ones(
    option: str,
    known: Iterable[str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, option, "Foo") == 2
    assert f"known: {', '.join(sorted(known))})" in capsys.readouterr().err


def test_judge_rejects_another_backend() -> None:
    with pytest.raises(UsageError, match="its own simulation"):
        list(JUDGE.measure(JUDGE.conditions[0], BodyChoice("mujoco", None), [0]))


@given(coordinate, coordinate, coordinate)
def test_camera_pair_looks_at_its_place(x: float, y: float, z: float) -> None:
    for place in looking_at((x, y, z)).places.values():
        axes = np.reshape(place.axes, (3, 3))
        np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-9)
        assert np.linalg.det(axes) > 0
        seen = axes.T @ (np.array([x, y, z]) - place.position)
        assert seen[0] > 0
        np.testing.assert_allclose(seen[1:], 0.0, atol=1e-9)


@given(st.floats(0.0, 1.0), st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=2))
def test_stroke_share_inverts_linear_interpolation(share: float, way: list[float]) -> None:
    opened, closed = np.array([0.04, 0.0]), np.array([0.04, 0.0]) + way
    if np.abs(way).max() < 1e-3:
        return
    reference = opened + share * (closed - opened)
    assert stroke_share(reference, opened, closed) == pytest.approx(share)


@pytest.mark.parametrize("file", PROGRAMS, ids=lambda file: file.stem)
def test_program_of_task_names_no_robot_and_fits_an_arm_with_edges(
    file: Path, tmp_path: Path
) -> None:
    text = file.read_text("utf-8").lower()
    assert not any(arm.lower() in text for arm in ARMS)
    robot = "dexter" if "second" in text else "panda"
    write_with_edges(robot, tmp_path)
    request = load(file, values={"robot": "seeing"}, folder=tmp_path)
    assert request.robot.name == "seeing"


def write_with_edges(robot: str, folder: Path) -> None:
    """Write a shipped robot as ``seeing``, with a sensor of edges for each hand."""
    (folder / "robots").mkdir()
    text = (ROOT / "robots" / f"{robot}.yaml").read_text("utf-8")
    hands = read_robot(ROOT / "robots" / f"{robot}.yaml")[0].load_cells
    sensors = ", ".join(f"edges_{hand}: {{kind: {EDGES.name}, hand: {hand}}}" for hand in hands)
    text = text.replace(f"name: {robot}\n", "name: seeing\n", 1)
    text = text.replace("\ncontrol:\n", f"\nsensors: {{{sensors}}}\n\ncontrol:\n", 1)
    (folder / "robots" / "seeing.yaml").write_text(text, "utf-8")
    shutil.copy(ROOT / "robots" / f"{robot}.urdf", folder / "robots")


class StillProcess:
    """Process in which nothing moves, and the red object covers a square of both images."""

    def __init__(self, width: int, height: int, joints: int, cells: int) -> None:
        self.requests: list[dict[str, Any]] = []
        self._joints, self._cells = joints, cells
        image = np.zeros((2, height, width), np.uint8)
        image[:, 100:110, 50:60] = 1
        self._pixels = image.tobytes()

    def ask(self, do: str, **request: Any) -> tuple[dict[str, Any], bytes]:
        self.requests.append({"do": do, **request})
        still = [0.0] * self._joints
        reply = {
            "positions": still,
            "velocities": still,
            "wrenches": [[0.0] * 6] * self._cells,
            "success": len(self.requests) == 4,
        }
        return reply, self._pixels if "label" in request else b""


def test_robosuite_backend_exposes_regions_at_the_image_rate(tmp_path: Path) -> None:
    robot, _ = read_robot(ROOT / "robots" / "panda.yaml")
    pair = looking_at((0.0, 0.0, 0.0))
    process = StillProcess(pair.width, pair.height, 8, 2)
    backend = RobosuiteBackend(robot, process, pair, {"red": ("cube",)})  # type: ignore[arg-type]
    write_with_edges("panda", tmp_path)
    stage = load(TASKS["Lift"].program, values={"robot": "seeing"}, folder=tmp_path).stage
    backend.reset(stage, None, np.random.default_rng(0))
    (region,) = backend.observe().regions["left"]["red"]
    assert (region.area, region.column, region.row) == (100, 55.0, 105.0)
    backend.step()
    assert not backend.observe().regions
    assert backend.ever_succeeded
    steps = [request for request in process.requests if request["do"] == "step"]
    # The fingers at zero are closed.
    assert [[len(arm) for arm in steps[0]["arms"]], steps[0]["closing"]] == [[7], [1.0]]


def test_mask_of_a_ring_is_filled_up_to_its_convex_outline() -> None:
    ring = np.zeros((9, 9), np.bool_)
    ring[2:7, 2:7] = True
    ring[4, 4] = ring[2, 4] = False
    np.testing.assert_array_equal(filled(ring).sum(), 25)


def test_mask_without_a_hole_keeps_its_dent() -> None:
    bent = np.zeros((9, 9), np.bool_)
    bent[2:4, 2:7] = bent[2:7, 2:4] = True
    np.testing.assert_array_equal(filled(bent), bent)


@pytest.mark.slow
@pytest.mark.skipif(bool(missing_environment()), reason=missing_environment() or "it is there")
def test_robosuite_judge_repeats_a_lift_that_the_task_accepts() -> None:
    (condition,) = (each for each in JUDGE.conditions if each.name == "Lift, Panda")
    first, second = (list(JUDGE.measure(condition, JUDGE.body, [0])) for _ in range(2))
    assert first == second
    assert first[0].outcomes["success"]
