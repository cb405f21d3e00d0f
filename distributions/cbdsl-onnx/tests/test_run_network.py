"""Programs that follow a network below guards, on the kinematic engine."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("onnxruntime")
from networks import PROGRAM, linear, write
from numpy.typing import NDArray

import cbdsl

OUTPUT = {"name": "y", "of": "right_arm.position"}
FLOOR = -0.04  # of the program's keep_out, m


def run(
    folder: Path, model: bytes, program: str = PROGRAM, **changes: Any
) -> tuple[NDArray[np.float64], str]:
    """Return time, s, tip's position, m, and rest below the guards, (ticks, 5), and the ending."""
    write(folder, "moved", model, **changes)
    (folder / "follow.yaml").write_text(program)
    loaded = cbdsl.load(folder / "follow.yaml")
    feedback = loaded.program.primitives["policy"].lead.feedback
    places: list[NDArray[np.float64]] = []

    def note(tick: Any) -> None:
        if tick.run.state[0] == "X" != tick.run.state[1]:
            rests = tick.run.state[1] == "1"
            places.append(
                np.hstack([tick.observation.time, tick.signals.read(feedback).value, rests])
            )

    (result,) = cbdsl.run(loaded, backend="kinematic", on_tick=note)
    return np.array(places), result.ending


def test_run_of_a_velocity_moves_at_that_velocity(tmp_path: Path) -> None:
    velocity = [0.02, 0.03, 0.01]
    places, _ = run(
        tmp_path,
        linear(np.zeros((3, 3)), np.array(velocity) / [2.0, 1.0, 1.0]),
        period="50 ms",
        output={**OUTPUT, "gives": "velocity", "deviation": [2.0, 1.0, 1.0]},
    )
    middle = len(places) // 2
    moved = places[-1] - places[middle]
    speed = moved[1:4] / moved[0]
    np.testing.assert_allclose(speed, velocity, rtol=0.05, atol=1e-4)
    assert not places[:, 4].any()  # the potential is constant, and the controller not at rest


def run_down(gives: str, folder: Path) -> tuple[NDArray[np.float64], str]:
    """Run a network that leads the tip straight down, to 26 cm or more below the guard."""
    output = [0.45, -0.25, -0.3] if gives == "target" else [0.0, 0.0, -0.3]
    return run(folder, linear(np.zeros((3, 3)), output), output={**OUTPUT, "gives": gives})


@pytest.mark.parametrize("gives", ["target", "displacement", "velocity"])
def test_run_of_a_network_below_a_guard_never_passes_it(gives: str, tmp_path: Path) -> None:
    places, _ = run_down(gives, tmp_path)
    assert places[:, 3].min() > FLOOR - 1e-3


@pytest.mark.parametrize("gives", ["target", "displacement", "velocity"])
def test_run_of_a_network_below_a_guard_ends_at_it(gives: str, tmp_path: Path) -> None:
    places, reason = run_down(gives, tmp_path)
    assert places[-1, 3] == pytest.approx(FLOOR, abs=2e-3)
    assert "held by keep_out" in reason


def withheld(folder: Path, gives: str, output: list[float]) -> list[float]:
    """Return the distances by which the tip stays behind a network, m, tick by tick."""
    write(folder, "moved", linear(np.zeros((3, 3)), output), output={**OUTPUT, "gives": gives})
    condition = "conditions: {behind: right_arm.net.withheld > 3 cm for 0.2 s}\n"
    text = PROGRAM.partition("actions:")[0] + condition + STEPS
    (folder / "follow.yaml").write_text(text)
    loaded, found = cbdsl.load(folder / "follow.yaml"), list[float]()
    behind = loaded.program.conditions["behind"].resources[0]

    def note(tick: Any) -> None:
        acts = tick.run.action is not None and "policy" in tick.run.action.name
        reading = tick.signals.read(behind) if acts else None
        if reading is not None:
            found.append(float(reading.value[0]))

    (result,) = cbdsl.run(loaded, backend="kinematic", on_tick=note)
    return [*found, float(result.outcome == "success")]


STEPS = """
steps:
  begin: {do: start, then: policy}
  policy: {do: policy ◁ keep_out ◁ force, exits: [behind: succeed]}
limits: {episode_time: 6 s}
"""


@pytest.mark.parametrize("gives", ["target", "displacement", "velocity"])
def test_network_that_a_guard_holds_back_is_withheld(gives: str, tmp_path: Path) -> None:
    output = [0.45, -0.25, -0.3] if gives == "target" else [0.0, 0.0, -0.3]
    *_, last, has_ended = withheld(tmp_path, gives, output)
    assert has_ended and last > 0.03


def test_network_that_moves_freely_is_not_withheld(tmp_path: Path) -> None:
    *found, has_ended = withheld(tmp_path, "velocity", [0.0, 0.02, 0.02])
    assert not has_ended and max(found) < 0.01


def test_run_without_a_finite_output_is_undefined_and_still(tmp_path: Path) -> None:
    # The product overflows float32, although the weights are finite.
    places, reason = run(tmp_path, linear(np.full((3, 3), 3e38), np.full(3, 3e38)))
    assert np.abs(places[-1, 1:] - places[0, 1:]).max() < 2e-3
    assert "right_arm.net" in reason
