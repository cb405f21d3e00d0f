"""Kept trials: written one by one, and not run again unless the setup has changed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from cbdsl.learning.impedance import ImpedanceProfile, ImpedanceTest
from cbdsl_reproduction.impedance_trials import ImpedanceTrial
from cbdsl_reproduction.kept_trials import KeptTrials, kept_trials

TEST = ImpedanceTest("dPz", -1, -0.002, -2.0, True, 0.0, -1.0)


def trial(seed: int) -> ImpedanceTrial:
    return ImpedanceTrial("box_on_box", seed, ImpedanceProfile((TEST,)), "Succeeded", 60.0)


def test_kept_trials_are_separated_by_experiment(tmp_path: Path) -> None:
    path = tmp_path / "folder" / "kept.jsonl"
    kept = KeptTrials(path, "one", ImpedanceTrial)
    kept.add(trial(1))
    kept.add(trial(2))
    again = KeptTrials(path, "one", ImpedanceTrial)
    assert again.get("box_on_box", 2) == trial(2)
    assert again.get("box_on_box", 3) is None and again.get("box_in_box", 2) is None
    assert KeptTrials(path, "other", ImpedanceTrial).get("box_on_box", 2) is None


def test_line_that_was_cut_off_is_run_again(tmp_path: Path) -> None:
    path = tmp_path / "kept.jsonl"
    KeptTrials(path, "one", ImpedanceTrial).add(trial(1))
    text = path.read_text()
    path.write_text(text + text[:40])
    kept = KeptTrials(path, "one", ImpedanceTrial)
    assert kept.get("box_on_box", 1) == trial(1)
    kept.add(trial(2))
    assert KeptTrials(path, "one", ImpedanceTrial).get("box_on_box", 2) == trial(2)


def test_only_missing_trials_run_and_progress_counts_all(tmp_path: Path) -> None:
    path, ran, heard = tmp_path / "kept.jsonl", list[int](), list[tuple[int, int]]()
    KeptTrials(path, "of box_on_box", ImpedanceTrial).add(trial(1))

    def run(things: str, seeds: Sequence[int]) -> Iterator[ImpedanceTrial]:
        ran.extend(seeds)
        return (trial(seed)._replace(things=things) for seed in seeds)

    def gathered() -> dict[str, list[ImpedanceTrial]]:
        return kept_trials(
            path,
            {"box_on_box": range(3), "box_in_box": range(2)},
            "of {}".format,
            ImpedanceTrial,
            run,
            lambda done, total: heard.append((done, total)),
        )

    first = gathered()
    assert [each.seed for each in first["box_on_box"]] == [0, 1, 2]
    assert [each.things for each in first["box_in_box"]] == ["box_in_box"] * 2
    assert ran == [0, 2, 0, 1]
    assert heard == [(2, 5), (3, 5), (4, 5), (5, 5)]
    assert gathered() == first and len(ran) == 4


@pytest.mark.parametrize("row", ["[1, 2]", "{}", '{"what": "one"}', '{"what": "one", "things": 3}'])
def test_row_of_another_kind_is_skipped(tmp_path: Path, row: str) -> None:
    path = tmp_path / "kept.jsonl"
    KeptTrials(path, "one", ImpedanceTrial).add(trial(1))
    path.write_text(f"{row}\n{path.read_text()}")
    assert KeptTrials(path, "one", ImpedanceTrial).get("box_on_box", 1) == trial(1)
