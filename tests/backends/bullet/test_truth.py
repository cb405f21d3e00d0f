"""Ground truth of recordings: the shapes of every body, as the stage describes them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.backends.staging.world_state import GroundTruthProvider
from cbdsl.documents.form import BoxForm
from cbdsl.documents.stage import StageDocument


def test_fixture_has_its_form_and_color(
    bullet: BulletBackend, stage: Callable[[str], StageDocument]
) -> None:
    assert isinstance(bullet, GroundTruthProvider)
    shown = stage("table_right")
    bullet.reset(shown, "in_view", np.random.default_rng(0))
    for name, fixture in shown.fixtures.items():
        (part,) = bullet.truth.parts(name)
        assert isinstance(fixture.form, BoxForm) and part.shape == "box"
        assert part.size == pytest.approx([span[0] for span in fixture.form.size])
        assert part.color == pytest.approx(fixture.color)
        assert part.position == pytest.approx((0, 0, 0))
        assert bullet.truth.pose(name).position == pytest.approx(
            [first for first, _ in fixture.position]
        )


def body(form: dict[str, object]) -> StageDocument:
    """Return a stage with an object of this form."""
    thing = {"form": form, "mass": "200 g", "color": [0, 1, 0]}
    context = {"things": ["it"], "place": {"z": "1 m"}}
    return StageDocument.model_validate(
        {
            "cbdsl": 1,
            "kind": "stage",
            "name": "made",
            "robot": "dexter",
            "things": {"it": thing},
            "contexts": {"only": context},
        }
    )


@pytest.mark.parametrize(
    ("form", "shape", "size"),
    [
        ({"shape": "ball", "radius": "5 cm"}, "ball", (0.05,)),
        ({"shape": "cylinder", "radius": "4 cm", "height": "20 cm"}, "cylinder", (0.04, 0.2)),
        ({"shape": "box", "size": ["1 cm", "2 cm", "3 cm"]}, "box", (0.01, 0.02, 0.03)),
    ],
)
def test_every_form_is_reported_with_its_size(
    bullet: BulletBackend, form: dict[str, object], shape: str, size: tuple[float, ...]
) -> None:
    bullet.reset(body(form), None, np.random.default_rng(0))
    (part,) = bullet.truth.parts("it")
    assert part.shape == shape and part.color == pytest.approx((0, 1, 0))
    assert part.size == pytest.approx(size)


def test_bars_are_parts_of_their_box(bullet: BulletBackend) -> None:
    pattern = {"height": "5 cm", "stripes": ["1 cm", "1 cm", "2 cm"]}
    form = {"shape": "box", "size": ["10 cm", "10 cm", "10 cm"], "pattern": pattern}
    bullet.reset(body(form), None, np.random.default_rng(0))
    box, *bars = bullet.truth.parts("it")
    assert box.size == pytest.approx((0.1, 0.1, 0.1))
    assert sorted(bar.size[1] for bar in bars) == pytest.approx([0.01, 0.02])
    assert all(bar.position[0] == pytest.approx(-0.05) for bar in bars)
