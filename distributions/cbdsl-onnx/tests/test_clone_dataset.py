"""Example of the whole loop: demonstrations, a LeRobot data set, a training, and a run."""

from __future__ import annotations

import shutil
from contextlib import suppress
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

pytest.importorskip("onnxruntime")
pytest.importorskip("pyarrow", reason="the example reads a LeRobot data set: cbdsl[lerobot]")
pytest.importorskip("torch", reason="the example trains by torch: pip install torch onnx")
pytest.importorskip("onnx", reason="torch exports models by onnx: pip install torch onnx")
import cbdsl
from cbdsl.cli.main import main
from cbdsl_onnx.model_file import load

EXAMPLE = Path(__file__).parents[1] / "examples" / "push_from_dataset"
SEED = 40_000


@pytest.fixture(scope="module")
def clone() -> ModuleType:
    spec = spec_from_file_location("clone_dataset", EXAMPLE / "clone_dataset.py")
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_exported_model_computes_the_trained_network(clone: ModuleType, tmp_path: Path) -> None:
    import torch

    network, rng = clone.Follower(5).eval(), np.random.default_rng(3)
    clone.export("images", network, 5, tmp_path / "net.onnx")
    image = rng.random((1, 3, clone.SIZE, clone.SIZE), np.float32)
    x = rng.normal(size=(1, 5)).astype("f4")
    session = load((tmp_path / "net.onnx").read_bytes())
    expected = network(torch.from_numpy(image), torch.from_numpy(x))[0].detach().numpy()
    np.testing.assert_allclose(session.run(["y"], {"image": image, "x": x})[0], expected, atol=1e-4)


def test_eye_of_the_example_finds_a_moved_spot(clone: ModuleType) -> None:
    """Features of a spot move with it, the same way everywhere."""
    import torch

    torch.manual_seed(1)
    eye, images = clone.Eye(), torch.zeros(3, 3, clone.SIZE, clone.SIZE)
    for place, row in enumerate((20, 40, 60)):
        images[place, :, row : row + 12, 40:52] = 5.0
    ways = torch.diff(eye(images), dim=0)
    assert (ways[0].abs() > 1e-3).any()
    np.testing.assert_allclose(ways[0].detach(), ways[1].detach(), atol=2e-2)


def test_documents_of_the_example_have_no_findings() -> None:
    assert [str(each) for each in cbdsl.check(*sorted(EXAMPLE.glob("*.yaml")))] == []
    for model in EXAMPLE.glob("*.onnx"):
        assert model.stat().st_size < 2_000_000


def cb(*words: str | Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run ``cb`` in this process."""
    monkeypatch.setattr("sys.argv", ["cb", *map(str, words)])
    with suppress(SystemExit):  # exit 0 is an exception, too
        main()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["states", "images"])
def test_loop_of_the_example_trains_a_network_that_runs(
    kind: str, clone: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for file in EXAMPLE.glob("*.yaml"):
        shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)
    demonstration = ("run", "approach_by_hand.yaml", "--backend", "kinematic", "--cameras")
    more = ("rendered", "--episodes", "2", "--seed", str(SEED), "--record", "tapes")
    cb(*demonstration, *more, monkeypatch=monkeypatch)
    signals = ("--signals", "right_arm.position,stereo.red")
    cb(
        "export",
        "lerobot",
        "tapes",
        *signals,
        "--fps",
        "20",
        "--out",
        "data",
        monkeypatch=monkeypatch,
    )
    monkeypatch.setattr(clone, "UPDATES", {"states": 1000, "images": 150})
    clone.main(kind, tmp_path / "data", tmp_path)
    program = tmp_path / "push_from_states.yaml"
    text = program.read_text("utf-8")
    program.write_text(text.replace("approach_by_states", f"approach_by_{kind}"), "utf-8")
    request = cbdsl.load(program)
    palm = request.program.primitives["policy"].lead.feedback
    # The episode of the first demonstration ends where its written controllers lead.
    goal = next(clone.demonstrations(tmp_path / "data")).palm[-1]
    apart: list[float] = []

    def note(tick: Any) -> None:
        if tick.run.action is not None and "policy" in tick.run.action.name:
            place = tick.signals.read(palm).value
            apart.append(float(np.linalg.norm(place - goal)))

    cbdsl.run(request, backend="kinematic", cameras="rendered", seed=SEED, on_tick=note)
    assert min(apart) < 0.3 * apart[0], (apart[0], min(apart))
