"""Background models: one sample per search, and a report of empty channels."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.documents.model import ModelDocument
from cbdsl.yaml_text.library import Library
from cbdsl_reproduction.chapter_4.posture_panels import PosturePanels
from cbdsl_reproduction.chapter_5.background_documents import write_backgrounds
from cbdsl_reproduction.chapter_5.background_model import (
    ChannelSearch,
    KeptSearches,
    Posture,
    TrackedPostures,
    looker,
    quantities,
    tracked_postures,
)
from cbdsl_reproduction.quantity import Verdict
from cbdsl_reproduction.simulation_fixture import simulation_fixture
from tests.conftest import ROOT

HERE: Posture = (0.1, 0.3)


def test_channel_without_tracked_postures_is_left_out() -> None:
    searches = [ChannelSearch("hue_1", seed, HERE if seed < 3 else ()) for seed in range(9)]
    assert tracked_postures("hue_1", searches) == TrackedPostures("hue_1", (HERE,) * 3, True)
    assert tracked_postures("hue_1", searches[:3]) == TrackedPostures("hue_1", (HERE,) * 3, False)


def test_kept_search_is_not_repeated(tmp_path: Path) -> None:
    path, made = tmp_path / "searches.jsonl", []

    def look(seed: int) -> Posture:
        made.append(seed)
        return HERE if seed else ()

    first = [KeptSearches(path).get("hue_1", seed, look) for seed in (0, 1)]
    with path.open("a", encoding="utf-8") as file:
        file.write('["hue_1", 2, [0.')
    again = KeptSearches(path)
    assert [again.get("hue_1", seed, look) for seed in (0, 1)] == first
    assert again.get("hue_1", 2, look).posture == HERE and made == [0, 1, 2]
    assert KeptSearches(path).get("hue_1", 2, look).posture == HERE and made == [0, 1, 2]


def test_empty_channels_are_reported() -> None:
    found = [TrackedPostures(f"hue_{n}", (HERE,) if n < 10 else (), n > 9) for n in range(1, 11)]
    found += [TrackedPostures(f"sat_{n}", (), True) for n in range(1, 11)]
    saturation, hue, intensity = quantities(found)
    assert hue.ours == 90 and hue.verdict is Verdict.REPRODUCED
    assert hue.note.endswith("empty: hue_10")
    assert saturation.verdict is Verdict.MISSED
    assert math.isnan(intensity.ours), "of no channels"


def test_panels_draw_tracked_channels_and_name_empty_ones() -> None:
    panels = {"hue_1": np.array([HERE, HERE, (0.5, -0.4)]), "hue_2": np.zeros((0, 2))}
    picture = PosturePanels("p", "Where", panels, {"pan": (-1.0, 1.0), "tilt": (-1.0, 1.0)})
    svg = picture.svg()
    assert "hue_1: 3" in svg and "hue_2: nothing" in svg
    assert "cells hue_1" in svg and "cells hue_2" not in svg


@pytest.mark.parametrize(("channel", "is_there"), [("hue_7", True), ("hue_9", False)])
def test_window_is_tracked_in_rendered_images_and_pink_is_not(channel: str, is_there: bool) -> None:
    with simulation_fixture("searchtrack", {"feature": channel}, "furnished") as lab:
        look = looker(lab)
        found = [look(seed) for seed in (5300000, 5300001)]
    assert [bool(posture) for posture in found] == [is_there] * 2
    if is_there:
        pans = [posture[0] for posture in found]
        assert max(pans) - min(pans) < 0.1, "the window stays where it is"


def test_backgrounds_are_models_of_the_channels_that_were_tracked(tmp_path: Path) -> None:
    tracked = {"hue_7": (HERE, (1.3, 0.2)), "hue_9": ()}
    write_backgrounds(tmp_path, "dexter", "head", "furnished", tracked)
    (path,) = tmp_path.iterdir()
    library = Library(ROOT)
    assert path.name == "furnished_hue_7.yaml" and not check_document(path, Session(library))
    model = library.read(path, ModelDocument).document
    assert (model.channel, model.effector) == ("hue_7", "head")
    assert model.density.form == "kernel" and model.density.samples == tracked["hue_7"]
