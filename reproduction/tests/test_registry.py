"""Registry: it has every module that measures, and every experiment cites the source."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import cbdsl_reproduction
from cbdsl_reproduction import registry
from cbdsl_reproduction.experiment import Experiment
from cbdsl_reproduction.registry import EXPERIMENTS

ALL = [pytest.param(each, id=each.name) for each in EXPERIMENTS.values()]


def test_every_experiment_is_registered_once() -> None:
    (folder,) = map(Path, cbdsl_reproduction.__path__)
    measuring = {
        ".".join(file.relative_to(folder).with_suffix("").parts)
        for file in folder.rglob("*.py")
        if re.search(
            r"^def run\(settings: RunSettings(, name: str)?\) -> Result:",
            file.read_text("utf-8"),
            re.M,
        )
    }
    assert {each.module for each in EXPERIMENTS.values()} == measuring
    lines = Path(registry.__file__).read_text("utf-8").count("    Experiment(")
    assert lines == len(EXPERIMENTS), "two have one name"
    alone = [each.module for each in EXPERIMENTS.values() if not each.learns]
    assert len(set(alone)) == len(alone)


@pytest.mark.parametrize("experiment", ALL)
def test_experiment_of_a_chapter_is_in_its_folder(experiment: Experiment) -> None:
    folder = re.match(r"chapter_(\d)\.", experiment.module)
    if folder is not None:
        first = re.search(r"(?:Section|Sections|Table|Figure) (\d)", experiment.section)
        # Transition diagrams of Chapter 4 serve Chapter 7, too.
        assert first is not None and int(first[1]) >= int(folder[1])


@pytest.mark.parametrize("experiment", ALL)
def test_experiment_names_its_section_table_or_figure(experiment: Experiment) -> None:
    assert re.fullmatch(r"[a-z0-9.-]+", experiment.name)
    assert re.search(r"\b(Section|Sections|Table|Figure|Equation)s? [0-9]", experiment.section)
    assert experiment.title
    assert callable(experiment.load())


def test_list_of_experiments_imports_nothing_heavy() -> None:
    script = (
        "import sys\nimport cbdsl_reproduction.registry\n"
        "sys.exit(any(name in sys.modules for name in ('numpy', 'pybullet', 'pinocchio')))"
    )
    assert subprocess.run([sys.executable, "-c", script]).returncode == 0
