"""``cb reproduce``: its list of experiments, its output and files, and wrong calls."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import types
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from cbdsl.storage.journal import JournalError
from cbdsl_reproduction import registry
from cbdsl_reproduction.chart import Chart, Line
from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.experiment import Experiment, Result, RunSettings
from cbdsl_reproduction.quantity import Quantity, computed
from cbdsl_reproduction.region import above
from tests.cli import test_main

TOY = Experiment("toy-1", "A toy", "Section 0", "toy")
OTHER = Experiment("toy-2", "Another toy", "Section 0.1", "toy")
KEPT = Experiment("toy-4", "A toy that keeps its episodes", "Section 0.3", "toy", keeps=True)
LEARNED = Experiment(
    "toy-3", "A toy that learns", "Section 0.2", "learned_toy", learns=True, backend="kinematic"
)


def cb(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Run ``cb reproduce`` in this process and return its exit code."""
    return test_main.cb(monkeypatch, "reproduce", *arguments)


@pytest.fixture
def toys(monkeypatch: pytest.MonkeyPatch) -> list[RunSettings]:
    """Register two experiments that take no time, and return the settings of their runs."""
    ran: list[RunSettings] = []

    def run(settings: RunSettings) -> Result:
        ran.append(settings)
        settings.progress(1, 2)
        chart = Chart("curve", "A curve", "t, s", "phi", (Line("one", (0.0, 1.0), (1.0, 0.0)),))
        most = Claim("", "share", "%", "most", above(50))
        share = Quantity(most, 75.0, (70.0, 80.0), note="a | b")
        unknown = Quantity(Claim("", "unknown", "", "some", above(0)), math.nan)
        return Result((share, unknown), (chart,), (f"Seed {settings.seed}.",))

    module = types.ModuleType("cbdsl_reproduction.toy")
    module.run = run  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(registry, "EXPERIMENTS", {each.name: each for each in (TOY, OTHER)})
    return ran


@pytest.fixture
def learning(toys: list[RunSettings], monkeypatch: pytest.MonkeyPatch) -> list[RunSettings]:
    """Register the toys and an experiment that learns."""

    def run(settings: RunSettings, name: str) -> Result:
        toys.append(settings)
        assert settings.folder.is_dir()
        return Result((computed(Claim("", name, "", "some", above(0)), 1.0),))

    module = types.ModuleType("cbdsl_reproduction.learned_toy")
    module.run = run  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, module.__name__, module)
    everything = {each.name: each for each in (TOY, LEARNED, OTHER)}
    monkeypatch.setattr(registry, "EXPERIMENTS", everything)
    return toys


def test_list_option_prints_all_experiments(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "--list") == 0
    printed = capsys.readouterr().out
    assert cb(monkeypatch, "--list", "--json") == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["experiment"] for row in rows] == list(registry.EXPERIMENTS)
    assert rows
    for row in rows:
        assert set(row.values()) <= {
            cell for line in printed.splitlines() for cell in line.split("\t")
        }


def test_list_of_a_name_prints_its_claims(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "fig-7.3", "--list", "--json") == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert (row["section"], row["expected"]) == ("Section 7.1.1, Figure 7.3", "0.15 ± 0.03")
    assert cb(monkeypatch, "engines", "--list") == 0
    assert "a region that the same trials bound" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("toy-11", "--list"), "did you mean 'toy-1'? (known: toy-1, toy-2, all)"),
        (("toy-11",), "did you mean 'toy-1'? (known: toy-1, toy-2, all)"),
        ((), "--list"),
        (("toy-1", "--out", "x.txt"), "expected a folder"),
        (("toy-1", "--out", "file/x"), "cannot be written"),
        (("toy-1", "--out", "folder.json"), "cannot be written"),
    ],
)
def test_wrong_calls_exit_with_2(
    arguments: tuple[str, ...],
    message: str,
    toys: list[RunSettings],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.json").mkdir()
    (tmp_path / "file").touch()
    assert cb(monkeypatch, *arguments) == 2
    assert message in capsys.readouterr().err
    assert not toys


def test_output_to_a_pipe_has_all_results(
    toys: list[RunSettings],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, "toy-1", "--seed", "7", "--quick") == 0
    heading, share, unknown, note, *_ = capsys.readouterr().out.splitlines()
    assert "toy-1" in heading and "Section 0" in heading
    assert share.split("\t")[1:6] == ["most", "75 [70, 80] %", "> 50", "0 %", "reproduced"]
    assert unknown.split("\t")[2:6] == ["none", "> 0", "0 %", "missed"]
    assert note == "Seed 7."
    assert [(each.seed, each.quick) for each in toys] == [(7, True)]


def test_json_of_all_experiments_has_one_entry_each(
    toys: list[RunSettings],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, "all", "--json") == 0
    first, second = json.loads(capsys.readouterr().out)
    assert (first["experiment"], second["experiment"]) == ("toy-1", "toy-2")
    assert [row["ours"] for row in first["quantities"]] == [75.0, None]
    assert first["charts"][0]["lines"] == {"one": [[0.0, 1.0], [1.0, 0.0]]}


def test_page_is_renewed_section_by_section(
    toys: list[RunSettings], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "pages"
    page = folder / "chapter_0.md"
    assert cb(monkeypatch, "toy-2", "--out", str(folder), "--seed", "2") == 0
    assert cb(monkeypatch, "toy-1", "--out", str(folder), "--seed", "1") == 0
    both = page.read_text("utf-8")
    summary = (folder / "index.md").read_text("utf-8")
    assert "2 of 4 judged rows (50 %) are reproduced" in summary
    assert "| [Chapter 0](chapter_0.md) | 2 | 0 | 0 | 2 | 0 |  |" in summary
    assert both.index("## toy-1: A toy") < both.index("## toy-2: Another toy")
    assert "Seed 2." in both and "| a \\| b |" in both
    ET.parse(folder / "curve.svg")
    assert cb(monkeypatch, "toy-1", "--out", str(folder), "--seed", "1") == 0
    assert page.read_text("utf-8") == both
    assert cb(monkeypatch, "toy-1", "--out", str(folder), "--seed", "3") == 0
    assert page.read_text("utf-8") == both.replace("Seed 1.", "Seed 3.").replace(
        "--seed 1", "--seed 3"
    )


def test_learned_result_has_a_section_for_each_backend(
    learning: list[RunSettings], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, keep = tmp_path / "pages", tmp_path / "a" / "trials"
    chosen = ("--backend", "bullet", "--trials", "3", "--keep", str(keep))
    assert cb(monkeypatch, "all", "--out", str(folder), *chosen) == 0
    assert cb(monkeypatch, "toy-3", "--out", str(folder)) == 0
    text = (folder / "chapter_0.md").read_text("utf-8")
    headings = [line.split(": ")[0] for line in text.splitlines() if line.startswith("## ")]
    assert headings == [
        "## Not reproduced", "## toy-1", "## toy-3", "## toy-3 on bullet", "## toy-2",
    ]  # fmt: skip
    assert "`cb reproduce toy-3 --seed 0 --backend bullet --trials 3`" in text
    assert "`cb reproduce toy-3 --seed 0 --backend kinematic`" in text
    assert "`cb reproduce toy-1 --seed 0`" in text
    kept, passing = learning[1], learning[-1]
    assert (kept.backend, kept.trials, kept.folder) == ("bullet", 3, keep) and keep.is_dir()
    assert not passing.folder.exists()


@pytest.mark.parametrize(
    "option",
    [("--backend", "bullet"), ("--trials", "3"), ("--workers", "2"), ("--keep", "x")],
    ids=lambda option: option[0],
)
def test_learning_options_are_refused_for_other_experiments(
    option: tuple[str, str],
    learning: list[RunSettings],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cb(monkeypatch, "toy-1", *option) == 2
    word = "run on a backend of choice" if option[0] == "--backend" else "learn"
    assert f"{option[0]} is for experiments that {word}, which toy-1" in capsys.readouterr().err
    assert not learning and not list(tmp_path.iterdir())


def test_keeping_experiment_accepts_keep_and_trials(
    toys: list[RunSettings],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(registry, "EXPERIMENTS", {KEPT.name: KEPT})
    folder, keep = tmp_path / "pages", tmp_path / "kept"
    chosen = ("--trials", "3", "--keep", str(keep), "--out", str(folder))
    assert cb(monkeypatch, "toy-4", *chosen) == 0
    assert [(each.trials, each.folder) for each in toys] == [(3, keep)]
    assert "`cb reproduce toy-4 --seed 0 --trials 3`" in (folder / "chapter_0.md").read_text(
        "utf-8"
    )
    assert cb(monkeypatch, "toy-4", "--workers", "2") == 2
    assert "--workers is for experiments that learn" in capsys.readouterr().err


def test_folder_that_cannot_be_created_is_reported(
    learning: list[RunSettings],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "file").touch()
    assert cb(monkeypatch, "toy-3", "--keep", str(tmp_path / "file")) == 2
    assert "--keep" in capsys.readouterr().err
    assert not learning


@pytest.mark.parametrize(
    ("error", "code", "told"),
    [
        (JournalError("x belongs to another trial"), 2, "holds other trials: x belongs to another"),
        (KeyboardInterrupt(), 130, "the same command goes on"),
    ],
)
def test_cause_of_an_unfinished_trial_is_reported_with_the_folder(
    error: BaseException,
    code: int,
    told: str,
    learning: list[RunSettings],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def run(settings: RunSettings, name: str) -> Result:
        raise error

    monkeypatch.setattr(sys.modules["cbdsl_reproduction.learned_toy"], "run", run)
    assert cb(monkeypatch, "toy-3", "--keep", str(tmp_path)) == code
    printed = capsys.readouterr().err
    assert str(tmp_path) in printed and told in printed


def test_json_option_writes_the_result_file(
    toys: list[RunSettings], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cb(monkeypatch, "all", "--out", str(tmp_path / "all.json")) == 0
    rows = json.loads((tmp_path / "all.json").read_text("utf-8"))
    assert [row["experiment"] for row in rows] == ["toy-1", "toy-2"]


def test_missing_package_is_reported() -> None:
    """Run in a separate process, because Python does not import loaded modules again."""
    script = (
        "import sys\nsys.modules['pybullet'] = None\n"
        "from cbdsl.cli.main import main\nsys.argv = ['cb', 'reproduce', 'fig-3.4']\nmain()\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith("cb: backend 'bullet' cannot be loaded: ")
    assert "try: pip install 'cbdsl[bullet]'" in done.stderr


@pytest.mark.slow
def test_two_workers_give_the_result_of_one_process_and_report_errors(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    pytest.importorskip("distributed", reason="side by side: extra 'learn'")
    command_line = ("fig-4.4", "--quick", "--trials", "2", "--json")
    printed = []
    for more in ((), ("--workers", "2", "--keep", str(tmp_path))):
        assert cb(monkeypatch, *command_line, *more) == 0
        printed.append(json.loads(capfd.readouterr().out))
    assert printed[0] == printed[1]
    journal = next(tmp_path.rglob("*_1.episodes.jsonl"))
    journal.write_text(journal.read_text().replace('"alpha": 0.1', '"alpha": 0.2'))
    again = ("--workers", "2", "--keep", str(tmp_path))
    assert cb(monkeypatch, *command_line, *again) == 2
    told = capfd.readouterr().err
    assert "holds other trials" in told and "alpha was 0.2, is 0.1" in told
