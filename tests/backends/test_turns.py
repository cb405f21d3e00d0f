"""Turns of the experimenter: things that come, are moved, and are put at new places."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.pose import Pose
from tests.backends.conftest import Simulated, made_stage

TABLE = {"form": {"shape": "box", "size": [2, 2, 0.1]}, "position": [1.5, 0, -0.45]}
BALL = {"form": {"shape": "ball", "radius": 0.05}, "mass": 0.3}


def stage(placed: dict[str, Any], **world: Any) -> StageDocument:
    things = {name: {"things": ["ball"], **each} for name, each in placed.items()}
    parts = {"fixtures": {"table": TABLE}, "things": {"ball": BALL}}
    return made_stage({"placed": things}, **parts, world={"persistent": True, **world})


def began(backend: Simulated, shown: StageDocument) -> None:
    backend.reset(shown, None, np.random.default_rng(0))


def place(backend: Simulated, name: str) -> tuple[float, float]:
    x, y, _ = backend.truth.pose(name).position.tolist()
    return x, y


def test_thing_comes_in_its_turn(unseeing: Simulated) -> None:
    later = {"place": {"on": "table", "x": 1.2, "y": 0.5}, "from_turn": 2}
    shown = stage({"now": {"place": {"on": "table", "x": 1.2}}, "later": later})
    began(unseeing, shown)
    names = [unseeing.truth.names()]
    for _ in range(3):
        unseeing.resume(shown, None)
        names.append(unseeing.truth.names())
    assert ["later" in each for each in names] == [False, False, True, True]
    assert all("now" in each for each in names)
    unseeing.step()
    assert place(unseeing, "later") == pytest.approx((1.2, 0.5), abs=1e-3)


def test_undisturbed_episode_is_no_turn(unseeing: Simulated) -> None:
    later = {"place": {"on": "table", "x": 1.2, "y": 0.5}, "from_turn": 1}
    shown = stage({"later": later})
    began(unseeing, shown)
    unseeing.resume(shown, None, undisturbed=True)
    assert "later" not in unseeing.truth.names()
    unseeing.resume(shown, None)
    assert "later" in unseeing.truth.names()


def test_thing_is_moved_for_good_in_its_turn(unseeing: Simulated) -> None:
    own = {"place": {"on": "table", "x": 1.2}, "displaced": [{"turn": 1, "by": [0, 0.25, 0]}]}
    shown = stage({"ball": own}, put_back="moved")
    began(unseeing, shown)
    for _ in range(2):
        unseeing.resume(shown, None)
        assert place(unseeing, "ball") == pytest.approx((1.2, 0.25), abs=1e-6)


def test_thing_is_scattered_about_its_place_and_within_its_bounds(unseeing: Simulated) -> None:
    bounds = {"x": [1.1, 1.4], "y": [-0.1, 0.3]}
    own = {"place": {"on": "table", "x": 1.2}, "scattered": {"deviation": 0.1, **bounds}}
    shown = stage({"ball": own})
    began(unseeing, shown)
    places = []
    for _ in range(60):
        unseeing.resume(shown, None)
        places.append(place(unseeing, "ball"))
    x, y = np.array(places).T
    assert x.min() >= 1.1 and x.max() <= 1.4 and y.min() >= -0.1 and y.max() <= 0.3
    assert 0.04 < x.std() < 0.1 and 0.05 < y.std() < 0.12


def test_scattered_things_keep_apart(unseeing: Simulated) -> None:
    wide = {"deviation": 0.2, "x": [1.1, 1.5], "y": [-0.2, 0.2]}
    each = {"scattered": wide, "apart": 0.03}
    placed = {
        "one": {"place": {"on": "table", "x": 1.2, "y": -0.1}, **each},
        "other": {"place": {"on": "table", "x": 1.2, "y": 0.1}, **each},
    }
    shown = stage(placed)
    began(unseeing, shown)
    for _ in range(40):
        unseeing.resume(shown, None)
        apart = np.subtract(place(unseeing, "one"), place(unseeing, "other"))
        assert np.hypot(*apart) >= 0.13 - 1e-9


def test_moved_object_is_put_at_a_newly_drawn_place(unseeing: Simulated) -> None:
    own = {"place": {"on": "table", "x": [1.1, 1.5], "y": [-0.2, 0.2]}}
    shown = stage({"ball": own}, put_back="moved", where="anew")
    began(unseeing, shown)
    before = place(unseeing, "ball")
    unseeing.resume(shown, None)
    assert place(unseeing, "ball") == pytest.approx(before, abs=1e-6), "it did not move"
    lifted = Pose(np.array([1.3, 0.0, 0.3]), np.eye(3))
    unseeing.truth.put_back("ball", lifted)
    unseeing.resume(shown, None)
    after = place(unseeing, "ball")
    assert after != pytest.approx(before, abs=1e-3)
    assert 1.1 <= after[0] <= 1.5 and -0.2 <= after[1] <= 0.2


def test_turns_are_for_persistent_worlds() -> None:
    with pytest.raises(ValidationError, match="persistent"):
        stage({"ball": {"place": {"on": "table"}, "from_turn": 3}}, persistent=False)
