"""Checks of networks: each fault gives one finding, and no file of bytes raises another error."""

from __future__ import annotations

import math
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("onnxruntime")
from networks import PROGRAM, linear, write

import cbdsl
from cbdsl_onnx import bounded, examples, wire
from cbdsl_onnx.model_file import ModelFacts, ModelFileError, examine

MODEL = examples.EXAMPLES["example"]
_CHECKING = "import cbdsl, sys; print(len(cbdsl.check(sys.argv[1])), 'onnxruntime' in sys.modules)"
OUTPUT = {"name": "y", "of": "right_arm.position", "gives": "displacement"}


def of_whole_numbers() -> bytes:
    info = wire.message((1, wire.message((1, 7), (2, wire.message((1, wire.message((1, 3))))))))
    weights = wire.tensor("scale", (3,), np.ones(3, "<f4").tobytes())
    ends = [wire.message((1, "x"), (2, info))], [wire.value_info("y", (3,))]
    return wire.model([wire.node("Identity", ("scale",), "y")], [weights], ends[0], ends[1])


def of_two_sizes() -> bytes:
    weights = wire.tensor("scale", (4,), np.ones(4, "<f4").tobytes())
    ends = [[wire.value_info(name, (1, 3))] for name in "xy"]
    return wire.model([wire.node("Mul", ("x", "scale"), "y")], [weights], ends[0], ends[1])


def of_shape(*shape: int) -> bytes:
    ends = [[wire.value_info(name, shape)] for name in "xy"]
    return wire.model([wire.node("Identity", ("x",), "y")], [], ends[0], ends[1])


_PLACE = wire.message((1, "location"), (2, "../../secret.bin"))
_OUTSIDE = wire.message((1, 3), (2, 7), (8, "i"), (13, _PLACE), (14, 1))


def of_outside_indices() -> bytes:
    attribute = wire.message((1, "sparse_value"), (22, wire.message((2, _OUTSIDE))))
    node = wire.node("Identity", ("x",), "y") + wire.message((5, attribute))
    ends = [[wire.value_info(name, (1, 3))] for name in "xy"]
    return wire.model([node], [], ends[0], ends[1])


def of_outside_default() -> bytes:
    attribute = wire.message((1, "weights"), (5, _OUTSIDE))
    return MODEL + wire.message((25, wire.message((1, "f"), (11, attribute))))


def of_product(size: int) -> bytes:
    """Return a model of few bytes that multiplies two matrices of zeros."""
    sizes = wire.message((1, 2), (2, 7), (8, "s"), (9, np.array([size, size], "<i8").tobytes()))
    steps = (("ConstantOfShape", ("s",), "h"), ("MatMul", ("h", "h"), "g"),
             ("ReduceMax", ("g",), "m"), ("Add", ("x", "m"), "y"))  # fmt: skip
    ends = [[wire.value_info(name, (1, 3))] for name in "xy"]
    return wire.model([wire.node(*each) for each in steps], [sizes], ends[0], ends[1])


FAULTS: dict[str, tuple[str, bytes, dict[str, Any]]] = {
    "indices in another file": ("NET102", of_outside_indices(), {}),
    "default in another file": ("NET102", of_outside_default(), {}),
    "opset of the future": ("NET103", examples.scaled(1, 1, 1, opset=99), {}),
    "shapes that do not match": ("NET103", of_two_sizes(), {}),
    "type of whole numbers": ("NET105", of_whole_numbers(), {}),
    "input of another name": ("NET105", MODEL, {"inputs": {"z": {"of": ["right_arm.position"]}}}),
    "output of another name": ("NET105", MODEL, {"output": {**OUTPUT, "name": "z"}}),
    "history beyond the shape": (
        "NET105",
        MODEL,
        {"inputs": {"x": {"of": ["right_arm.position"], "history": 2}}},
    ),
    "chunk beyond the shape": ("NET105", MODEL, {"output": {**OUTPUT, "steps": 4}}),
    "feedback of another size": ("NET105", MODEL, {"output": {**OUTPUT, "of": "right_arm"}}),
    "feedback without differences": (
        "NET106",
        MODEL,
        {"output": {**OUTPUT, "of": "right_arm.orientation"}},
    ),
    "image as a feedback": ("NET106", MODEL, {"output": {**OUTPUT, "of": "left.image"}}),
    "drawn signal": ("NET106", MODEL, {"inputs": {"x": {"of": ["head.uniform"]}}}),
    "deviation of another size": ("NET107", MODEL, {"output": {**OUTPUT, "deviation": [1.0]}}),
    "more executed than given": ("NET108", MODEL, {"output": {**OUTPUT, "execute": 2}}),
    "input without bounds": ("NET103", of_shape(10**9, 10**9), {}),
    "mean that is no number": ("CB109", MODEL, {"output": {**OUTPUT, "mean": [0, 0, math.nan]}}),
    "deviation of 0": ("CB208", MODEL, {"output": {**OUTPUT, "deviation": [1.0, 0.0, 1.0]}}),
    "period below a tick": ("NET108", MODEL, {"period": "1 ms", "deadline": "1 ms"}),
    "unknown robot": ("CB601", MODEL, {"robot": "robbie"}),
}


@pytest.mark.parametrize(("code", "model", "changes"), FAULTS.values(), ids=FAULTS)
def test_check_of_a_faulty_network_has_one_finding(
    code: str, model: bytes, changes: dict[str, Any], tmp_path: Path
) -> None:
    findings = cbdsl.check(write(tmp_path, "bad", model, **changes))
    assert [each.code for each in findings if each.code != "CB704"] == [code], findings


def test_check_of_a_huge_model_reads_none_of_it(tmp_path: Path) -> None:
    path = write(tmp_path, "huge", MODEL)
    os.truncate(tmp_path / "huge.onnx", 2_000_000_000)
    (finding,) = cbdsl.check(path)
    assert finding.code == "NET101" and "500000000" in finding.message


REASONS = {
    "pickle": (pickle.dumps({"weights": [1.0]}), "it is a pickle"),
    "pickle of protocol 2": (pickle.dumps({"weights": [1.0]}, protocol=2), "it is a pickle"),
    "archive of torch": (b"PK\x03\x04archive/data.pkl", "it is a pickle"),
    "opset of the future": (examples.scaled(1, 1, 1, opset=99), "its opset 99 is newer than"),
    "no bytes": (b"", "it has no graph"),
}


@pytest.mark.parametrize(("model", "reason"), REASONS.values(), ids=REASONS)
def test_check_of_a_file_without_a_usable_model_gives_the_reason(
    model: bytes, reason: str, tmp_path: Path
) -> None:
    (finding,) = cbdsl.check(write(tmp_path, "bad", model))
    assert reason in finding.message


@pytest.mark.parametrize("size", [9_000, 10**6])
def test_check_of_a_model_that_asks_for_much_ends(
    size: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    short = "import cbdsl_onnx.bounded as b; b._MOST_SECONDS = 2; main()"
    monkeypatch.setattr(bounded, "_BEGIN", bounded._BEGIN.replace("main()", short))
    (finding,) = cbdsl.check(write(tmp_path, "large", of_product(size)))
    assert finding.code == "NET103" and "a dry run on zeros" in finding.message


def test_check_of_a_network_runs_it_in_another_process(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", _CHECKING, str(write(tmp_path, "moved", MODEL))],
        capture_output=True,
        text=True,
    )
    assert done.stdout.split() == ["0", "False"], done.stderr


def test_check_of_a_missing_model_names_the_file(tmp_path: Path) -> None:
    path = write(tmp_path, "gone", MODEL)
    (tmp_path / "gone.onnx").unlink()
    (finding,) = cbdsl.check(path)
    assert finding.code == "NET101" and "gone.onnx" in finding.message


@settings(max_examples=150, deadline=None)
@given(st.integers(0, len(MODEL) - 1), st.binary(max_size=6), st.integers(0, 4))
def test_examine_of_changed_bytes_returns_facts_or_names_the_fault(
    place: int, inserted: bytes, removed: int
) -> None:
    try:
        facts = examine(MODEL[:place] + inserted + MODEL[place + removed :])
    except ModelFileError as error:
        assert str(error)
    else:
        assert isinstance(facts, ModelFacts)


@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
def test_examine_of_any_weight_that_is_not_finite_refuses_it(place: int, number: float) -> None:
    weights = [1.0, 1.0, 1.0]
    weights[place] = number
    with pytest.raises(ModelFileError, match="not finite") as caught:
        examine(examples.scaled(*weights))
    assert caught.value.fault == "weights"


def test_check_of_a_program_reports_the_faults_of_its_network_once(tmp_path: Path) -> None:
    write(tmp_path, "moved", examples.EXAMPLES["not_finite"])
    (tmp_path / "follow.yaml").write_text(PROGRAM)
    assert [each.code for each in cbdsl.check(tmp_path / "follow.yaml")] == ["NET104"]


def test_digest_of_a_program_follows_the_bytes_of_its_network(tmp_path: Path) -> None:
    (tmp_path / "follow.yaml").write_text(PROGRAM)
    digests = []
    for bias in (0.0, 0.0, 0.1):
        write(tmp_path, "moved", linear(np.zeros((3, 3)), [bias, 0, 0]))
        digests.append(cbdsl.load(tmp_path / "follow.yaml").digest.sha256)
    assert digests[0] == digests[1] != digests[2]
