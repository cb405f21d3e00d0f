"""Sections of the page, which do not share their pictures."""

from __future__ import annotations

from cbdsl_reproduction.chart import Chart
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.registry import EXPERIMENTS
from cbdsl_reproduction.report import picture_file, section


def test_pictures_of_sections_have_distinct_names() -> None:
    chart = Chart("fig-4.4", "Some", "x", "y", ())
    learns, other = EXPERIMENTS["fig-4.4"], EXPERIMENTS["fig-3.4"]
    kinematic, bullet = RunSettings(), RunSettings(backend="bullet")
    assert picture_file(chart, learns, kinematic) == "fig-4.4.svg"
    assert picture_file(chart, learns, bullet) == "fig-4.4-bullet.svg"
    assert picture_file(chart, other, bullet) == "fig-4.4.svg"
    assert "(fig-4.4-bullet.svg)" in section(learns, bullet, Result((), (chart,)))


def test_links_have_no_spaces() -> None:
    chart = Chart("fig-6.2", "Some", "x", "y", ())
    settings = RunSettings(backend="mujoco", cameras="ideal")
    text = section(EXPERIMENTS["fig-6.2"], settings, Result((), (chart,)))
    assert "(fig-6.2-mujoco-with-ideal-cameras.svg)" in text
