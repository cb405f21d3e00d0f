"""From a clone to a program of one's own within a first day, by the docs alone, three times."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path

import pytest

from tests.first_day import DAY, Clone, Reader, assert_shown, clone, first_command

pytestmark = pytest.mark.first_day


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Clone:
    """Return a clone set up as the README says; its time counts in each of the days."""
    folder = clone(tmp_path_factory.mktemp("clone"))
    setup, _ = first_command()
    began = time.monotonic()
    done = subprocess.run(setup.split(), cwd=folder, capture_output=True, text=True, timeout=DAY)
    if done.returncode and "No matching distribution" in done.stderr:
        pytest.skip("pip reaches no package index")
    assert done.returncode == 0, done.stderr
    return Clone(folder, time.monotonic() - began)


@pytest.fixture
def reader(here: Clone, tmp_path: Path) -> Reader:
    return Reader(here, tmp_path)


def test_readme_leads_to_a_program_that_is_rewarded(reader: Reader, tmp_path: Path) -> None:
    _, run = first_command()
    assert "Rewarded after" in reader.type(run.removeprefix(".venv/bin/"))
    assert (tmp_path / "reachtouch.html").is_file()
    assert "Rewarded after" in reader.watch(".venv/bin/cb run reachtouch --live --live-wait")
    reader.read("README.md")
    reader.type("cb validate watch.yaml")
    assert "watch on table_right" in reader.type("cb run watch.yaml")
    assert reader.seconds < DAY


def test_tutorial_leads_to_a_program_that_runs(reader: Reader, tmp_path: Path) -> None:
    reader.read("docs/tutorial.md")
    assert "hover" in reader.type("cb list programs")
    assert (tmp_path / "tapes" / "episode_2.html").is_file()
    assert (tmp_path / "looking.yaml").is_file()
    assert reader.seconds < DAY


def test_new_stage_and_new_exploration_work_in_a_fresh_clone(
    reader: Reader, tmp_path: Path
) -> None:
    reader.read("docs/how_to/new_stage.md")
    reader.read("docs/how_to/explore_a_catalog.md")
    assert (tmp_path / "programs" / "stages" / "tidying.yaml").is_file()
    assert "searchtrack" in (tmp_path / "ball.yaml").read_text("utf-8")
    assert reader.seconds < DAY


def test_output_on_a_page_that_no_command_prints_is_noticed() -> None:
    assert_shown("one\n...\nthree\n", "zero\none\ntwo\nthree \n")
    with pytest.raises(AssertionError):
        assert_shown("one\n...\nfour\n", "one\ntwo\nthree\n")
