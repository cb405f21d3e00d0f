"""Features are read at the first moment at which most of them are defined."""

from __future__ import annotations

from types import SimpleNamespace as Made
from typing import Any

import numpy as np
import pytest

from cbdsl.runtime.feature_reader import FeatureReader
from cbdsl.types.resource import Origin, Resource, StereoPosition, StereoSignal, SurfacePoint
from cbdsl.types.resource_type import POSITION, VOLUME

PLACE = Resource("stereo.ball", POSITION, Origin.TRIANGULATION, StereoPosition("ball"))
SIZE = Resource("stereo.ball.volume", VOLUME, Origin.TRIANGULATION, StereoSignal("ball", "volume"))
POINT = Resource("surface.ball", POSITION, Origin.SURFACE, SurfacePoint("ball"))


def tick(number: int, defined: dict[Any, float], run: Any = None, table: Any = None) -> Any:
    """Return a 0.1 s tick in which resources have a value, by their place in memory."""

    def read(resource: Any) -> Any:
        value = defined.get(id(resource))
        return None if value is None else Made(value=np.array([[value, 2.0]]))

    signals = Made(read=read, table=table)
    return Made(observation=Made(time=0.1 * number), signals=signals, run=run)


def test_moment_with_most_features_counts_and_after_all_are_there_none() -> None:
    reader = FeatureReader({"place": PLACE, "size": SIZE})
    place, both = {id(PLACE): 1.0}, {id(PLACE): 5.0, id(SIZE): 6.0}
    for number in range(1, 4):
        reader.note_tick(tick(number, both))
    assert not reader.values, "images come at every fourth tick"
    reader.note_tick(tick(4, place))
    assert reader.values == {"place": (1.0, 2.0)}
    for number in range(5, 9):
        reader.note_tick(tick(number, {id(PLACE): 3.0}))
    assert reader.values == {"place": (1.0, 2.0)}, "no more are defined than before"
    for number in range(9, 13):
        reader.note_tick(tick(number, both))
    assert reader.values == {"place": (5.0, 2.0), "size": (6.0, 2.0)}
    for number in range(13, 17):
        reader.note_tick(tick(number, {id(PLACE): 7.0, id(SIZE): 8.0}))
    assert reader.values["place"] == (5.0, 2.0)


def test_how_long_a_resource_was_defined_is_noted() -> None:
    reader = FeatureReader({}, {"seen": PLACE})
    for number in range(1, 17):
        reader.note_tick(tick(number, {id(PLACE): 1.0} if number > 7 else {}))
    assert reader.seconds == pytest.approx({"seen": 1.2})
    assert FeatureReader({}).seconds == {}


def test_drawn_feature_is_the_draw_of_the_controller_that_goes_there() -> None:
    def going(row: int, reference: Any) -> Any:
        return Made(controller=Made(reference=reference), rows=Made(declared=row))

    drawn = {3: np.array([0.1, 0.2, 0.3])}
    table = Made(is_defined=lambda row: row in drawn, values=drawn.get)
    child = Made(runs=[going(3, PLACE), going(2, POINT), going(3, POINT)], children={})
    run = Made(runs=[going(1, POINT)], children={"find": child})
    reader = FeatureReader({"point": POINT})
    for number in range(4):
        reader.note_tick(tick(number, {}, run, table))
    assert reader.values == {"point": (0.1, 0.2, 0.3)}
    child.runs.pop()
    again = FeatureReader({"point": POINT})
    for number in range(4):
        again.note_tick(tick(number, {}, run, table))
    assert again.values == {}
