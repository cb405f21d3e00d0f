"""The height of a table from its outline, as two turning cameras see it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from cbdsl.backends.backend import embody
from cbdsl.documents.robot import Camera, RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.robot.resources import resources
from cbdsl.sensing.channels import Extent, connected_regions
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.vision.shapes.surface import (
    LevelSurface,
    SurfaceSampler,
    SurfaceView,
    find_height,
)

CAMERA = Camera(link="eye", width=320, height=240, focal_length=418.5)
HEIGHT = -0.42
BASELINE = 0.3


def turned(pan: float, tilt: float) -> NDArray[np.float64]:
    """Return the axes ahead, left and up of a head that looks down by a tilt, as columns."""
    c, s, d, t = np.cos(pan), np.sin(pan), np.cos(tilt), np.sin(tilt)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array(
        [[d, 0, t], [0, 1, 0], [-t, 0, d]]
    )


def views(pan: float, tilt: float, line: NDArray[np.float64]) -> list[SurfaceView]:
    """Return the views of two cameras on a straight line in the world, as far as it is visible."""
    rotation = turned(pan, tilt)
    both = []
    for side in (0.5, -0.5):
        eye = np.array([0.2, 0.0, 0.5]) + side * BASELINE * rotation[:, 1]
        own = (line - eye) @ rotation
        pixels = np.stack(
            [160 - 418.5 * own[:, 1] / own[:, 0], 120 - 418.5 * own[:, 2] / own[:, 0]], -1
        )
        inside = (own[:, 0] > 0.1) & (pixels > 0).all(axis=1) & (pixels < (320, 240)).all(axis=1)
        kept = pixels[inside]
        outline = ((*kept[0].tolist(), *kept[-1].tolist()),) if len(kept) > 1 else ()
        both.append(SurfaceView(CAMERA, Frame(eye, rotation), Extent(outline, ((160.5, 200.5),))))
    return both


def edge(x: float, y: float, angle: float, height: float = HEIGHT) -> NDArray[np.float64]:
    along = np.linspace(-0.5, 0.5, 400)[:, None]
    level = np.array([np.cos(angle), np.sin(angle), 0.0])
    return np.array([x, y, height]) + along * level


@given(
    pan=st.floats(-0.6, 0.6),
    tilt=st.floats(0.9, 1.2),
    angle=st.floats(-3, 3),
    height=st.floats(-0.6, -0.2),
)
def test_edge_gives_its_height_or_none(
    pan: float, tilt: float, angle: float, height: float
) -> None:
    found = find_height(*views(pan, tilt, edge(0.75, 0.75 * np.tan(pan), angle, height)))
    assert found is None or found == pytest.approx(height, abs=0.005)


@pytest.mark.parametrize("pan", [-0.4, 0.0, 0.4])
def test_edge_across_the_baseline_gives_a_height_and_one_along_it_none(pan: float) -> None:
    middle = 0.75, 0.75 * np.tan(pan)
    across, along = (views(pan, 1.0, edge(*middle, pan + turn)) for turn in (0.0, np.pi / 2))
    assert find_height(*across) == pytest.approx(HEIGHT, abs=0.003)
    assert find_height(*along) is None


def test_surface_without_an_outline_keeps_its_height() -> None:
    surface, rng = LevelSurface(), np.random.default_rng(0)
    sampler = SurfaceSampler(surface, rng)
    nothing = [each._replace(extent=Extent((), ((160.5, 120.5),)))
               for each in views(0.0, 1.0, edge(0.75, 0, 0))]  # fmt: skip
    assert surface.points.shape == (0, 3)
    surface.see(*nothing)
    assert surface.height is None and sampler.draw() is None
    surface.see(*views(0.0, 1.0, edge(0.75, 0, 0.2)))
    surface.see(*nothing)
    point = sampler.draw()
    assert point is not None and point[2] == pytest.approx(HEIGHT, abs=0.005)
    surface.reset()
    assert sampler.draw() is None


def test_extent_of_a_region_leaves_out_the_images_border() -> None:
    mask = np.zeros((240, 320), np.uint8)
    mask[100:, :200] = 255
    (region,) = connected_regions(mask, 12)
    assert region.extent is not None
    ends = {frozenset([each[:2], each[2:]]) for each in region.extent.outline}
    corner = (199.5, 100.5)
    assert ends == {frozenset([(0.5, 100.5), corner]), frozenset([corner, (199.5, 239.5)])}
    cover = np.array(region.extent.cover)
    assert len(cover) > 50 and (cover[:, 0] < 192).all() and (cover[:, 1] > 108).all()


def test_whole_or_a_small_region_has_no_extent() -> None:
    mask = np.zeros((240, 320), np.uint8)
    mask[10:200, 10:200] = 255
    mask[:30, 300:] = 255
    assert [each.extent for each in connected_regions(mask, 12)] == [None, None]


@pytest.mark.parametrize(("columns", "fills"), [(21, True), (19, False)])
def test_region_of_a_sixteenth_of_the_image_fills_it(columns: int, fills: bool) -> None:
    mask = np.zeros((240, 320), np.uint8)
    mask[:, :columns] = 255
    (region,) = connected_regions(mask, 12)
    assert (region.extent is not None) is fills


@pytest.mark.parametrize("cameras", ["rendered", "ideal"])
def test_points_are_on_the_table(
    cameras: str,
    dexter: RobotDocument,
    urdf: Path,
    kinematics: Kinematics,
    stage: Callable[[str], StageDocument],
) -> None:
    backend = embody("bullet", dexter, urdf, cameras=cameras)
    signals = Signals(dexter, kinematics, [resources(dexter)["surface.green"]])
    (surface,) = signals.sensors.surfaces.by_channel.values()
    known = 0
    for seed in range(12):
        signals.reset()
        backend.reset(stage("bare_table"), "in_view", np.random.default_rng(seed))
        signals.update(backend.observe())
        if surface.height is None:
            assert not len(surface.points)
            continue
        known += 1
        assert surface.height == pytest.approx(HEIGHT, abs=0.01)
        x, y, _ = surface.points.T
        assert x.min() > 0.28 and x.max() < 0.92 and np.abs(y).max() < 0.62
    assert known >= 4
    backend.close()
