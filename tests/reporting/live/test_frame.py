"""Frames: images are small and in their colours, undefined numbers null."""

from __future__ import annotations

import base64
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from cbdsl.reporting.live import frame as module
from cbdsl.reporting.live.frame import images


def test_images_keep_their_colours_at_half_the_size() -> None:
    image = np.zeros((48, 64, 3), np.uint8)
    image[:, :32, 0], image[:, 32:, 2] = 250, 200
    tick = SimpleNamespace(observation=SimpleNamespace(images={"left": image}))
    pack = images(tick)  # type: ignore[arg-type]
    image[:] = 0  # a backend may draw the next image into the same array
    shown = cv2.imdecode(
        np.frombuffer(base64.b64decode(pack()["left"]), np.uint8), cv2.IMREAD_COLOR
    )
    assert shown.shape == (24, 32, 3)
    assert shown[12, 4].astype(int) == pytest.approx([0, 0, 250], abs=25), (
        "red, blue first as cv2 has it"
    )
    assert shown[12, 28].astype(int) == pytest.approx([200, 0, 0], abs=25)


def test_undefined_numbers_are_null_and_others_as_exact_as_a_page_needs() -> None:
    given = np.array([np.nan, np.inf, 0.0, 1 / 3, -1e-9])
    assert module._numbers(given) == [None, None, 0.0, 0.333333, -1e-9]
