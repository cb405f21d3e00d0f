"""Touch maps: one sample per rewarded episode, and a judgement of the samples' positions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.documents.model import ModelDocument
from cbdsl.yaml_text.library import Library
from cbdsl_reproduction.chapter_5.cross_sections import CrossSections
from cbdsl_reproduction.chapter_5.touch_map import bandwidth, gather, run
from cbdsl_reproduction.chapter_5.touch_trials import SOURCES, Place, TouchTrial, touch_digest
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.kept_trials import KeptTrials
from cbdsl_reproduction.quantity import Verdict
from tests.conftest import ROOT

WANTED = 40
MIDDLES = {"table": (0.6, 0.2, -0.42), "object": (0.6, -0.2, -0.36), "bimanual": (0.5, 0.0, -0.05)}


def keep(folder: Path, higher: float = 0.0, vain: int = 0) -> RunSettings:
    """Keep episodes of each source, the first ``vain`` of them without reward."""
    rng, file = np.random.default_rng(0), folder / "touch_mujoco_ideal.jsonl"
    for name in SOURCES:
        kept = KeptTrials(file, touch_digest(name), TouchTrial)
        kind = name.partition("_")[0]
        for seed in range(WANTED + vain):
            spread = (0.02, 0.02, 0.002) if kind == "bimanual" else (0.1, 0.2, 0.002)
            place = rng.normal(MIDDLES[kind], spread).clip((0.31, -0.59, -9), (0.89, 0.59, 9))
            place[2] += higher
            felt: Place = () if seed < vain else tuple(place.tolist())
            kept.add(TouchTrial(name, seed, felt))
    return RunSettings(folder=folder, trials=WANTED, backend="mujoco", cameras="ideal")


def test_samples_are_gathered_until_there_are_enough(tmp_path: Path) -> None:
    trials = gather(keep(tmp_path, vain=3))
    assert {name: len(own) for name, own in trials.items()} == dict.fromkeys(SOURCES, WANTED + 3)


@pytest.mark.parametrize(("higher", "verdict"), [(0.0, Verdict.REPRODUCED), (0.02, Verdict.MISSED)])
def test_height_of_the_table_is_judged(tmp_path: Path, higher: float, verdict: Verdict) -> None:
    result = run(keep(tmp_path, higher))
    judged = {each.name: each.verdict for each in result.quantities if each.expected is not None}
    assert judged.pop("table: height of touches") is verdict
    assert set(judged.values()) == {Verdict.REPRODUCED}


def test_maps_are_models_that_programs_can_draw_from(tmp_path: Path) -> None:
    run(keep(tmp_path))
    for name, source in SOURCES.items():
        path = tmp_path / f"touch_map_{name}.yaml"
        assert not check_document(path, Session(Library(ROOT)))
        model = Library(ROOT).read(path, ModelDocument).document
        assert (model.effector, model.space) == (source.arm, "position")
        assert model.density.form == "kernel" and len(model.density.samples) == WANTED


def test_kernel_width_falls_with_the_number_of_samples() -> None:
    places = np.random.default_rng(0).normal(size=(400, 3)) * (0.2, 0.1, 0.0)
    few, many = bandwidth(places[:20]), bandwidth(places)
    assert (few[:2] > 1.1 * many[:2]).all() and few[2] == many[2] > 0


def test_peak_is_where_most_samples_are() -> None:
    samples = {"table": np.array([(0.4, 0.5, 0.0)]), "bimanual": np.full((3, 3), 0.6)}
    picture = CrossSections("p", "Where", samples, 0.03, np.array([(0.3, 0, -0.1), (0.9, 1, 0)]))
    assert picture.peak() == pytest.approx([0.6, 0.6])
    assert picture.density(0, 1, np.array([(0.6, 0.6)])) == pytest.approx(3.0)
    svg = picture.svg()
    assert "table: 1" in svg and "bimanual: 3" in svg and svg.count("samples ") == 2 * 2


@pytest.mark.slow
def test_contact_places_lie_on_the_table(tmp_path: Path) -> None:
    """Run two episodes of each way to touch, by load cells and kinematics alone."""
    settings = RunSettings(
        seed=5605000, quick=True, folder=tmp_path, backend="mujoco", cameras="ideal"
    )
    found = {each.name: each.ours for each in run(settings).quantities}
    assert found["table: height of touches"] == pytest.approx(-0.42, abs=0.002)
    assert 0.03 < found["object: height of touches above those of the table"] < 0.12
    assert -0.1 < found["bimanual: height of touches"] < 0.0
    assert gather(replace(settings, backend="mujoco")) == gather(settings), "kept, not run again"
