"""``cb judge``: its list of judges, its output and files, and wrong calls."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

import cbdsl
from cbdsl_reproduction.interval import exact_interval
from cbdsl_reproduction.judges import registry
from cbdsl_reproduction.judges import result as judge_results
from cbdsl_reproduction.judges.judge import (
    NONE,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)
from tests.cli import test_main


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Let every fourth seed of the hard condition fail."""
    for seed in seeds:
        good = condition.name == "easy" or seed % 4 > 0
        yield EpisodeVerdict(
            seed, {"good": good, "false": False}, 2.0, "it ended", {"error_mm": 1.0}
        )


_AIMS = {"good": Aim(0.9), "false": NONE}
TOY = Judge(
    "toy",
    "a toy",
    tuple(JudgedCondition(name, "reachtouch", _AIMS) for name in ("easy", "hard one")),
    _measure,
    BodyChoice("kinematic", "ideal"),
    episodes=8,
)


@pytest.fixture(autouse=True)
def toy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Register a judge that takes no time."""
    monkeypatch.setattr(registry, "JUDGES", {"toy": TOY})


def cb(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Run ``cb judge`` in this process and return its exit code."""
    return test_main.cb(monkeypatch, "judge", *arguments)


def test_judge_lists_the_judges(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "--list", "--json") == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert row == {
        "judge": "toy", "title": "a toy", "conditions": ["easy", "hard one"],
        "programs": ["reachtouch"], "episodes": 8,
    }  # fmt: skip
    assert cb(monkeypatch, "--list") == 0
    assert capsys.readouterr().out == "Judges\ntoy\ta toy\t8\n"


def test_judge_writes_counts_with_exact_intervals_and_provenance(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "results"
    assert cb(monkeypatch, "toy", "--seed", "4", "--json", "--out", str(out)) == 1
    result = json.loads(capsys.readouterr().out)
    assert result == json.loads((out / "toy.json").read_text())
    assert result["command"] == (
        "cb judge toy --seed 4 --episodes 8 --backend kinematic --cameras ideal"
    )
    assert result["versions"]["cbdsl"] and {"commit", "seed", "episodes"} <= set(result)
    hard = next(r for r in result["rows"] if r["condition"] == "hard one")
    assert (hard["successes"], hard["n"], hard["met"]) == (6, 8, False)
    assert hard["interval"] == pytest.approx(exact_interval(6, 8), abs=5e-5)
    assert [seed for _, seed, _ in hard["amiss"]] == [4, 8]
    assert result["measures"]["easy"]["error_mm"] == [1.0, 1.0, 1.0]


def test_judge_command_in_result_repeats_the_result(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["toy", "--only", "hard one", "--seed", "3", "--episodes", "5", "--json"]
    cb(monkeypatch, *arguments)
    result = json.loads(capsys.readouterr().out)
    cb(monkeypatch, *shlex.split(result["command"])[2:], "--json")
    assert json.loads(capsys.readouterr().out) == result


def test_judge_prints_a_line_per_count(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "toy", "--only", "easy") == 0
    assert capsys.readouterr().out == (
        "toy: a toy\n"
        "easy\tgood\t8 of 8\t63.1 to 100.0 %\tat least 90 %\tmet\n"
        "easy\tfalse\t0 of 8\t0.0 to 36.9 %\tnone\tmet\n"
    )


def test_judge_only_replaces_the_rows_that_it_measured(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = tmp_path / "toy.json"
    cb(monkeypatch, "toy", "--seed", "4", "--out", str(tmp_path))
    before = json.loads(file.read_text())
    again = ["--only", "easy", "--seed", "9", "--episodes", "3"]
    cb(monkeypatch, "toy", *again, "--out", str(tmp_path))
    after = json.loads(file.read_text())
    cells = ("condition", "outcome", "successes", "n", "interval")
    rows = {
        "before": {tuple(map(str, (row[key] for key in cells))) for row in before["rows"]},
        "after": {tuple(map(str, (row[key] for key in cells))) for row in after["rows"]},
    }
    hard = {row for row in rows["before"] if row[0] == "hard one"}
    assert hard and hard <= rows["after"]
    assert {row[3] for row in rows["after"] - hard} == {"3"}
    assert [row["condition"] for row in after["rows"]] == [
        row["condition"] for row in before["rows"]
    ]
    own = {row["condition"]: row.get("run", after)["command"] for row in after["rows"]}
    assert own["hard one"] == before["command"] and "--only easy" in own["easy"]
    assert after["measures"]["hard one"] == before["measures"]["hard one"]
    assert after["met"] is False
    cb(monkeypatch, "toy", "--only", "hard one", "--seed", "2", "--out", str(tmp_path))
    third = json.loads(file.read_text())
    assert {row.get("run", third)["seed"] for row in third["rows"]} == {2, 9}


def _interrupted(monkeypatch: pytest.MonkeyPatch, condition: str) -> list[str]:
    """Interrupt the toy judge in a condition, once; return the list of measured conditions."""
    measured: list[str] = []

    def measure(
        judged: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
    ) -> Iterator[EpisodeVerdict]:
        measured.append(judged.name)
        if judged.name == condition and measured.count(condition) == 1:
            raise KeyboardInterrupt
        return _measure(judged, body, seeds)

    monkeypatch.setattr(registry, "JUDGES", {"toy": replace(TOY, measure=measure)})
    return measured


def test_judge_resumes_after_the_finished_conditions(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file, arguments = tmp_path / "toy.json", ["toy", "--seed", "4", "--out", str(tmp_path)]
    measured = _interrupted(monkeypatch, "hard one")
    assert cb(monkeypatch, *arguments) == 130
    told = capsys.readouterr()
    assert f"interrupted; {file} has 1 of 2 conditions; --resume continues" in told.err
    assert {row["condition"] for row in json.loads(file.read_text())["rows"]} == {"easy"}
    assert cb(monkeypatch, *arguments, "--resume") == 1
    assert measured == ["easy", "hard one", "hard one"]
    resumed = capsys.readouterr().out
    assert cb(monkeypatch, *arguments, "--resume") == 1
    assert len(measured) == 3 and capsys.readouterr().out == resumed
    assert cb(monkeypatch, *arguments) == 1
    assert capsys.readouterr().out == resumed and len(measured) == 5


@pytest.mark.parametrize(
    "change", [["--seed", "5"], ["--episodes", "9"], ["--cameras", "rendered"]]
)
def test_judge_resumes_no_conditions_of_another_run(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, change: list[str]
) -> None:
    arguments = ["toy", "--seed", "4", "--out", str(tmp_path)]
    measured = _interrupted(monkeypatch, "")
    cb(monkeypatch, *arguments)
    cb(monkeypatch, *arguments, *change, "--resume")
    assert measured == ["easy", "hard one"] * 2


def test_judge_resumes_no_conditions_of_changed_code(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    arguments = ["toy", "--seed", "4", "--out", str(tmp_path)]
    measured = _interrupted(monkeypatch, "")
    cb(monkeypatch, *arguments)
    # A commit without a change of the judged code keeps the result.
    monkeypatch.setattr(judge_results, "commit", lambda: "another")
    cb(monkeypatch, *arguments, "--resume")
    assert measured == ["easy", "hard one"]
    monkeypatch.setattr(judge_results, "row_digests", lambda *of: {"law": "another"})
    cb(monkeypatch, *arguments, "--resume")
    assert measured == ["easy", "hard one"] * 2


def test_judge_interrupted_without_a_folder_keeps_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _interrupted(monkeypatch, "hard one")
    assert cb(monkeypatch, "toy") == 130
    assert "interrupted; no result is kept without --out" in capsys.readouterr().err


def test_judge_refuses_a_foreign_result_file_before_any_episode(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "toy.json").write_text("[1, 2]")
    assert cb(monkeypatch, "toy", "--out", str(tmp_path)) == 2
    told = capsys.readouterr()
    assert "holds no result of cb judge toy; move it away" in told.err and not told.out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "which judge? cb judge --list names them"),
        (["toyy"], "unknown judge 'toyy'; did you mean 'toy'? (known: toy)"),
        (
            ["toy", "--only", "easyy"],
            "unknown condition of toy 'easyy'; did you mean 'easy'? (known: easy, hard one)",
        ),
        (["toy", "--out", "/dev/null/results"], "--out /dev/null/results: cannot be written"),
        (["toy", "--resume"], "--resume: which results? name their folder by --out"),
        (["toy", "--workers", "100000"], "--workers 100000: at most"),
        (["toy", "--episode", "3"], "--episodes"),
        (["toy", "--episodes", "0"], "--episodes"),
    ],
)
def test_judge_refuses_a_wrong_call(
    arguments: list[str],
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, *arguments) == 2
    told = capsys.readouterr()
    assert message in told.err and not told.out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--backend", "kinematik"], "unknown backend 'kinematik'; did you mean 'kinematic'?"),
        (["--cameras", "drawn"], "drawn"),
    ],
)
def test_judge_refuses_an_unknown_body(
    arguments: list[str],
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    from cbdsl_reproduction.judges import success_rates

    monkeypatch.setattr(registry, "JUDGES", {"success_rates": success_rates.JUDGE})
    assert cb(monkeypatch, "success_rates", "--only", "right", *arguments) == 2
    assert message in capsys.readouterr().err


def test_judge_counts_kinematic_episodes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from cbdsl_reproduction.judges import success_rates

    monkeypatch.setattr(registry, "JUDGES", {"success_rates": success_rates.JUDGE})
    arguments = ["--only", "absent", "--seed", "11", "--episodes", "1", "--backend", "kinematic"]
    assert cb(monkeypatch, "success_rates", *arguments, "--json") == 0
    result = json.loads(capsys.readouterr().out)
    request = cbdsl.load("reachtouch", stage="absent")
    (expected,) = cbdsl.run(request, seed=11, backend="kinematic")
    assert result["rows"][0]["successes"] == expected.rewarded == 0
    assert result["measures"]["absent"]["simulated_s"][0] == pytest.approx(
        expected.sim_seconds, abs=1e-3
    )
