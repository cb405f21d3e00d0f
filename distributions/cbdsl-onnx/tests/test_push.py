"""The shipped network and its program: found by name, guarded, and replaced by written steps."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

pytest.importorskip("onnxruntime")
from networks import linear

import cbdsl
from cbdsl_onnx.network import NETWORK

assert NETWORK.brought is not None
SHIPPED = NETWORK.brought
SEED = 1_004


def copied(
    folder: Path, changes: Sequence[tuple[str, str]] = (), model: bytes | None = None
) -> Path:
    """Copy the shipped documents; return the program.

    Args:
        folder: Folder for the copies.
        changes: Texts of the program, each with its replacement.
        model: Bytes that replace the model.
    """
    for file in SHIPPED.rglob("*.*"):
        if file.suffix in (".yaml", ".onnx"):
            shutil.copy(file, folder)
    if model is not None:
        (folder / "push_thing.onnx").write_bytes(model)
    program = folder / "push_by_network.yaml"
    text = program.read_text("utf-8")
    for before, after in changes:
        assert text.count(before) == 1
        text = text.replace(before, after)
    program.write_text(text, "utf-8")
    return program


def pushed(program: str | Path, seed: int) -> tuple[Any, float, bool]:
    """Return the result, the thing's last y by truth, m, and whether the table was touched."""
    with cbdsl.simulate(program, backend="kinematic") as simulation:
        truth, touched = simulation.truth, []

        def note(tick: Any) -> None:
            touched.append(truth.is_touched("table"))

        result = simulation.robot.run(seed, on_tick=note)
        (thing,) = set(truth.objects) - {"table"}
        return result, float(truth.position(thing)[1]), any(touched)


def steps(result: Any) -> set[str]:
    """Return the names of the members that moved the arm's position."""
    known = {"policy", "above", "behind", "again", "push", "withdraw"}
    return known.intersection(*[[word for action in result.actions for word in action.split()]])


def test_shipped_documents_have_no_findings() -> None:
    assert [str(each) for each in cbdsl.check(*sorted(SHIPPED.rglob("*.yaml")))] == []
    assert (SHIPPED / "knowledge/networks/push_thing.onnx").stat().st_size < 2_000_000


def test_shipped_program_is_found_by_name_from_anywhere(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", "from cbdsl.cli.main import main; main()", "show", "program",
         "push_by_network"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )  # fmt: skip
    assert done.returncode == 0 and "right_arm.net" in done.stdout, done.stdout + done.stderr


def test_shipped_network_pushes_the_thing_to_the_line_and_touches_no_table() -> None:
    result, last, touched = pushed("push_by_network", SEED)
    assert result.succeeded, result.ending
    assert steps(result) == {"policy", "withdraw"}  # the network alone
    assert -0.1 < last < 0.0 and not touched


def test_network_that_stands_still_gives_way_to_the_written_steps(tmp_path: Path) -> None:
    program = copied(tmp_path, model=linear(np.zeros((12, 6)), np.zeros(12)))
    result, last, _ = pushed(program, SEED)
    assert result.succeeded, result.ending
    assert steps(result) == {"policy", "above", "behind", "again", "push", "withdraw"}
    assert -0.1 < last < 0.0


def test_undefined_network_gives_way_to_the_written_steps(tmp_path: Path) -> None:
    # The product overflows float32, although the weights are finite.
    program = copied(tmp_path, model=linear(np.full((12, 6), 3e38), np.full(12, 3e38)))
    result, last, _ = pushed(program, SEED)
    assert result.succeeded and -0.1 < last < 0.0, result.ending
    assert "push" in steps(result)


def test_network_that_a_guard_holds_comes_back_after_the_written_steps(tmp_path: Path) -> None:
    # A floor above the thing holds the first try alone.
    program = copied(
        tmp_path,
        [
            (
                "  keep_in: {",
                "  floor: {potential: at_least, reference: -24 cm, axes: [z], "
                "feedback: right_arm.position, effector: right_arm.position}\n  keep_in: {",
            ),
            ("level ◁ policy ◁ keep_out ◁ keep_in", "level ◁ policy ◁ floor"),
        ],
    )
    result, last, _ = pushed(program, SEED)
    assert result.succeeded and -0.1 < last < 0.0, result.ending
    assert steps(result) == {"policy", "above", "behind", "again", "withdraw"}


@pytest.mark.parametrize("step", ["above", "behind"])
def test_written_step_that_cannot_arrive_withdraws_and_looks_again(
    step: str, tmp_path: Path
) -> None:
    height = {"above": "20 cm", "behind": "3 cm"}[step]
    program = copied(
        tmp_path,
        [
            (f"-24 cm, {height}]", f"-90 cm, {height}]"),
            ("episode_time: 60 s", "episode_time: 25 s"),
        ],
        linear(np.zeros((12, 6)), np.zeros(12)),
    )
    result, _, _ = pushed(program, SEED)
    order = _steps(result)
    begin = order.index(step)
    assert order[begin : begin + 4] == [step, "withdraw", "verify", "above"], order
    assert not result.succeeded and "25 s" in result.ending, result.ending


def _steps(result: Any) -> list[str]:
    """Return the steps of an episode in turn, by the last member below the guards."""
    return [name for name, _ in groupby(map(_lead, result.actions))]


def _lead(action: str) -> str:
    guards = {"keep_out", "keep_in", "force"}
    return next(word for word in reversed(action.split(" ◁ ")) if word not in guards)


def test_steps_of_the_shipped_program_end_when_they_are_stuck_or_undefined() -> None:
    """A step that ends only when its controller has arrived goes on while it is held."""
    (file,) = SHIPPED.rglob("push_by_network.yaml")
    document = yaml.safe_load(file.read_text("utf-8"))
    for name, step in document["steps"].items():
        exits = " or ".join(key for each in step.get("exits", ()) for key in each)
        if "do" not in step:
            continue
        lead = _lead(step["do"])
        assert f"{lead} at rest" in exits or f"{lead} stuck" in exits, name
        reference = document["controllers"][lead]["reference"]
        if "stereo" in str(reference) or ".net" in str(reference):
            assert f"{lead} undefined" in exits, name


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3_020, 3_040))
def test_shipped_network_succeeds_on_seeds_that_it_was_not_trained_on(seed: int) -> None:
    result, last, touched = pushed("push_by_network", seed)
    assert result.succeeded and -0.1 < last < 0.0 and not touched, result.ending
