"""Images of cameras as inputs of networks: their pixels, their checks, and runs that see them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

pytest.importorskip("onnxruntime")
from networks import PROGRAM, write

import cbdsl
from cbdsl.extend.backend import BackendError, Observation
from cbdsl_onnx import wire
from cbdsl_onnx.camera_images import CameraImages, pixels
from cbdsl_onnx.inference import Inference
from cbdsl_onnx.plan import InputPlan, Normalisation

SIZE = (6, 8)
IMAGE: dict[str, Any] = {"of": ["left.image"], "size": list(SIZE)}
FLOATS, BYTES, WHOLE = 1, 2, 7


def seeing(*shape: int, kind: int = FLOATS, output: tuple[float, ...] = (0.0, 0.0, 0.0)) -> bytes:
    """Return a model with an image `x` and the constant output `y`."""
    dims = wire.message(*((1, wire.message((1, size))) for size in shape))
    info = wire.message((1, "x"), (2, wire.message((1, wire.message((1, kind), (2, dims))))))
    constant = wire.tensor("c", (1, len(output)), np.array(output, "<f4").tobytes())
    node = wire.node("Identity", ("c",), "y")
    return wire.model([node], [constant], [info], [wire.value_info("y", (1, len(output)))])


def plan(
    dtype: str = "float32", channels_first: bool = True, size: tuple[int, int] = SIZE, **more: Any
) -> InputPlan:
    scale = more.pop("scale", Normalisation((), ()))
    return InputPlan("x", (), scale, 1, (), dtype, "left", size, channels_first)


FITTING = {
    "channels first": ((1, 3, 6, 8), FLOATS, 1),
    "channels last": ((1, 6, 8, 3), FLOATS, 1),
    "bytes": ((1, 3, 6, 8), BYTES, 1),
    "history": ((1, 4, 6, 8, 3), FLOATS, 4),
    "history of channels": ((1, 12, 6, 8), FLOATS, 4),
}
FAULTS: dict[str, tuple[str, tuple[int, ...], int, dict[str, Any]]] = {
    "other size": ("NET105", (1, 3, 6, 9), FLOATS, IMAGE),
    "height and width in turn": ("NET105", (1, 3, 8, 6), FLOATS, IMAGE),
    "four channels": ("NET105", (1, 4, 6, 8), FLOATS, IMAGE),
    "history of last channels": ("NET105", (1, 6, 8, 6), FLOATS, {**IMAGE, "history": 2}),
    "whole numbers": ("NET105", (1, 3, 6, 8), WHOLE, IMAGE),
    "normalised bytes": ("NET105", (1, 3, 6, 8), BYTES, {**IMAGE, "deviation": [1, 1, 1]}),
    "mean of one number": ("NET107", (1, 3, 6, 8), FLOATS, {**IMAGE, "mean": [0.5]}),
    "no size": ("NET106", (1, 3, 6, 8), FLOATS, {"of": ["left.image"]}),
    "size of 0": ("CB208", (1, 3, 6, 8), FLOATS, {**IMAGE, "size": [0, 8]}),
    "no such camera": ("NET106", (1, 3, 6, 8), FLOATS, {**IMAGE, "of": ["lefft.image"]}),
    "image and signal": (
        "NET106",
        (1, 3, 6, 8),
        FLOATS,
        {**IMAGE, "of": ["left.image", "right_arm.position"]},
    ),
    "size of a signal": ("NET106", (1, 3), FLOATS, {**IMAGE, "of": ["right_arm.position"]}),
    "bytes of a signal": ("NET105", (1, 3), BYTES, {"of": ["right_arm.position"]}),
}


@pytest.mark.parametrize(("shape", "kind", "history"), FITTING.values(), ids=FITTING)
def test_check_of_an_image_that_fits_the_model_has_no_finding(
    shape: tuple[int, ...], kind: int, history: int, tmp_path: Path
) -> None:
    path = write(
        tmp_path, "sees", seeing(*shape, kind=kind), inputs={"x": {**IMAGE, "history": history}}
    )
    assert [str(each) for each in cbdsl.check(path)] == []


@pytest.mark.parametrize(("code", "shape", "kind", "section"), FAULTS.values(), ids=FAULTS)
def test_check_of_an_image_that_does_not_fit_has_one_finding(
    code: str, shape: tuple[int, ...], kind: int, section: dict[str, Any], tmp_path: Path
) -> None:
    path = write(tmp_path, "bad", seeing(*shape, kind=kind), inputs={"x": section})
    assert [each.code for each in cbdsl.check(path)] == [code]


def test_check_of_a_misspelt_camera_names_the_image(tmp_path: Path) -> None:
    inputs = {"x": {**IMAGE, "of": ["lefft.image"]}}
    (finding,) = cbdsl.check(write(tmp_path, "bad", seeing(1, 3, 6, 8), inputs=inputs))
    assert "left.image" in str(finding)


@given(st.integers(0, 255), st.booleans(), st.sampled_from(["uint8", "float32", "float16"]))
def test_pixels_of_a_plain_image_have_its_value(value: int, first: bool, dtype: str) -> None:
    found = pixels(np.full((24, 32, 3), value, np.uint8), plan(dtype, first))
    assert found.shape == ((3, *SIZE) if first else (*SIZE, 3)) and found.dtype == dtype
    np.testing.assert_allclose(found, value if dtype == "uint8" else value / 255, rtol=1e-3)


def test_pixels_are_means_of_areas_in_their_order() -> None:
    image = np.random.default_rng(5).integers(0, 256, (12, 16, 3), dtype=np.uint8)
    means = image.reshape(6, 2, 8, 2, 3).mean(axis=(1, 3))
    found = pixels(image, plan(scale=Normalisation((0.5, 0.2, 0.1), (1.0, 2.0, 0.5))))
    expected = (means / 255 - [0.5, 0.2, 0.1]) / [1.0, 2.0, 0.5]
    # Bytes are rounded before they are divided.
    np.testing.assert_allclose(found.transpose(1, 2, 0), expected, atol=0.6 / 255 / 0.5)


@dataclass
class World:
    """Time and observers of a robot with images at 10 Hz, 50 ms late."""

    time: float = 0.0
    observers: list[Any] = field(default_factory=list)
    robot: Any = field(
        default_factory=lambda: SimpleNamespace(vision=SimpleNamespace(rate=10.0, latency=0.05))
    )

    def observe(self, time: float, images: Any, regions: Any = None) -> None:
        self.time = time
        none = np.zeros(0)
        for notify in self.observers:
            notify(Observation(time, none, none, {}, images, regions or {}))


def test_image_stays_for_three_periods_and_is_then_undefined() -> None:
    world, image = World(), np.zeros((4, 4, 3), np.uint8)
    images = CameraImages("net", ["left"], world)  # type: ignore[arg-type]
    assert images.read("left") is None
    world.observe(1.0, {"left": image})
    assert images.read("left") is image
    for time, is_defined in ((1.05, True), (1.34, True), (1.36, False)):
        world.observe(time, {})
        assert (images.read("left") is image) == is_defined, time
    world.observe(0.0, {})  # the next episode
    assert images.read("left") is None


def test_images_of_ideal_cameras_are_an_error_at_the_first_observation() -> None:
    world = World()
    CameraImages("net", ["left"], world)  # type: ignore[arg-type]
    with pytest.raises(BackendError, match=r"'net' needs images of left.*--cameras rendered"):
        world.observe(0.0, {}, {"left": {}})


def test_network_without_images_runs_with_ideal_cameras() -> None:
    world = World()
    CameraImages("net", [], world)  # type: ignore[arg-type]
    world.observe(0.0, {}, {"left": {}})


def run(folder: Path, monkeypatch: pytest.MonkeyPatch, cameras: str | None) -> dict[str, Any]:
    """Run a network that sees two images; return its inputs, and the images at their time."""
    inputs = {"x": {**IMAGE, "history": 2}}
    write(folder, "moved", seeing(1, 2, *SIZE, 3), inputs=inputs)
    (folder / "follow.yaml").write_text(PROGRAM)
    seen: dict[str, Any] = {"feeds": [], "images": [], "positions": []}
    request = Inference.request

    def note(inference: Inference, feeds: dict[str, NDArray[Any]]) -> None:
        seen["feeds"].append(feeds["x"])
        request(inference, feeds)

    def tick(now: Any) -> None:
        seen["images"] += [now.observation.images["left"]] if now.observation.images else []
        seen["positions"].append(now.observation.positions)

    monkeypatch.setattr(Inference, "request", note)
    cbdsl.run(
        cbdsl.load(folder / "follow.yaml"), backend="kinematic", cameras=cameras, on_tick=tick
    )
    return seen


def test_run_gives_the_newest_images_to_the_network(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = run(tmp_path, monkeypatch, "rendered")
    assert len(seen["feeds"]) > 5
    known = [pixels(image, plan(channels_first=False)) for image in seen["images"]]
    for feed in seen["feeds"]:
        assert feed.shape == (1, 2, *SIZE, 3) and 0.0 < feed.mean() < 1.0
        # Both observations are images of the camera, the later one not before the other.
        first, last = (
            next(k for k, image in enumerate(known) if np.array_equal(image, each))
            for each in feed[0]
        )
        assert first <= last


def test_run_with_ideal_cameras_ends_before_anything_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(BackendError, match="network 'moved' needs images of left"):
        run(tmp_path, monkeypatch, None)
