"""Policies of LeRobot through the door of networks, by a fake library of the same interface."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("onnxruntime")
from networks import PROGRAM, write

import cbdsl
from cbdsl_onnx.lerobot_policy import PYTHON, PolicySession

OUTPUT = {"name": "action", "of": "right_arm.position", "gives": "target"}
STATE = {"observation.state": {"of": ["right_arm.position"]}}
#: Features as LeRobot writes them.
CONFIG: dict[str, Any] = {
    "type": "shift",
    "input_features": {"observation.state": {"type": "STATE", "shape": [3]}},
    "output_features": {"action": {"type": "ACTION", "shape": [3]}},
}
FACTORY = """
import numpy
class Policy:
    count = 0
    @classmethod
    def from_pretrained(cls, folder, config): return cls()
    def eval(self): pass
    def reset(self): self.count = 0
    def select_action(self, batch):
        self.count += 1
        image = batch.get("observation.images.left", numpy.ones((1, 3, 9, 12), "f4"))
        assert image.shape == (1, 3, 9, 12) and image.dtype == "f4"
        return batch["observation.state"] + numpy.array([[0.0, 0.02 * image.max(), 0.0]])
def get_policy_class(name): return Policy
"""
CONFIGS = """
import json, types
class PreTrainedConfig:
    @staticmethod
    def from_pretrained(folder):
        return types.SimpleNamespace(**json.load(open(folder + "/config.json")))
"""
TORCH = "import contextlib, numpy\ntensor, no_grad = numpy.array, contextlib.nullcontext\n"


@pytest.fixture
def lerobot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Have a fake lerobot and a fake torch in the environment that ``CB_LEROBOT`` names."""
    site = tmp_path / "site"
    modules = {
        "torch": TORCH,
        "lerobot/__init__": "",
        "lerobot/configs/__init__": "",
        "lerobot/configs/policies": CONFIGS,
        "lerobot/policies/__init__": "",
        "lerobot/policies/factory": FACTORY,
    }
    for name, text in modules.items():
        (site / f"{name}.py").parent.mkdir(parents=True, exist_ok=True)
        (site / f"{name}.py").write_text(text)
    monkeypatch.setenv("PYTHONPATH", str(site))
    monkeypatch.setenv(PYTHON, sys.executable)
    return site


def policy(folder: Path, config: dict[str, Any] | None = CONFIG, **changes: Any) -> Path:
    """Write a policy and its document; return the document."""
    weights = folder / "shift" / "model.safetensors"
    weights.parent.mkdir(parents=True)
    weights.write_bytes(b"\0" * 8)
    if config is not None:
        (weights.parent / "config.json").write_text(json.dumps(config))
    document = {"file": "shift/model.safetensors", "inputs": STATE, "output": OUTPUT, **changes}
    return write(folder, "moved", b"", **document)


@pytest.mark.usefixtures("lerobot")
@pytest.mark.parametrize("sees", [False, True])
def test_program_follows_a_policy_of_lerobot(sees: bool, tmp_path: Path) -> None:
    if sees:
        image = {"type": "VISUAL", "shape": [3, 9, 12]}
        features = {**CONFIG["input_features"], "observation.images.left": image}
        inputs = {**STATE, "observation.images.left": {"of": ["left.image"], "size": [9, 12]}}
        policy(tmp_path, {**CONFIG, "input_features": features}, inputs=inputs)
    else:
        policy(tmp_path)
    (tmp_path / "follow.yaml").write_text(PROGRAM)
    loaded = cbdsl.load(tmp_path / "follow.yaml")
    feedback, places = loaded.program.primitives["policy"].lead.feedback, []

    def note(tick: Any) -> None:
        if tick.run.state[0] == "X" and tick.run.state[1] != "X":
            places.append(tick.signals.read(feedback).value.copy())

    cbdsl.run(loaded, backend="kinematic", cameras="rendered" if sees else None, on_tick=note)
    moved = places[-1] - places[0]
    assert moved[1] > 0.03 and np.abs(moved[[0, 2]]).max() < 0.01


def test_policy_without_its_environment_is_one_finding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(PYTHON, raising=False)
    (finding,) = cbdsl.check(policy(tmp_path))
    assert finding.code == "NET103" and PYTHON in finding.message


FAULTS: dict[str, tuple[str, dict[str, Any] | None]] = {
    "no configuration": ("NET101", None),
    "no features": ("NET101", {"type": "shift"}),
    "image in place of a state": (
        "NET105",
        {**CONFIG, "input_features": {"observation.state": {"type": "VISUAL", "shape": [3, 9, 9]}}},
    ),
    "other size": (
        "NET105",
        {**CONFIG, "input_features": {"observation.state": {"type": "STATE", "shape": [7]}}},
    ),
    "other action": (
        "NET105",
        {**CONFIG, "output_features": {"action": {"type": "ACTION", "shape": [7]}}},
    ),
}


@pytest.mark.usefixtures("lerobot")
@pytest.mark.parametrize(("code", "config"), FAULTS.values(), ids=FAULTS)
def test_check_of_a_faulty_policy_has_one_finding(
    code: str, config: dict[str, Any] | None, tmp_path: Path
) -> None:
    (finding,) = cbdsl.check(policy(tmp_path, config))
    assert finding.code == code


def test_policy_that_cannot_be_loaded_says_why(tmp_path: Path, lerobot: Path) -> None:
    (lerobot / "lerobot/policies/factory.py").write_text("raise ImportError('no such policy')")
    policy(tmp_path)
    with pytest.raises(ValueError, match="no such policy"):
        PolicySession(tmp_path / "shift" / "model.safetensors")
