"""Python verbs: their results, their exceptions, and imports without start-up cost."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import cbdsl
from cbdsl.documents.policy import PolicyDocument
from cbdsl.runtime.tick import Tick
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

SEED = 3_600_000


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_import_of_cbdsl_loads_no_module_and_lists_its_names() -> None:
    code = (
        "import sys, cbdsl; print([m for m in sys.modules if m.startswith('cbdsl.')], dir(cbdsl))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("[] ")
    assert all(f"'{name}'" in done.stdout for name in cbdsl.__all__)
    assert all(getattr(cbdsl, name).__name__ == name for name in cbdsl.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'verify'"):
        cbdsl.verify  # noqa: B018


def test_checking_imports_no_simulator() -> None:
    code = (
        "import sys, cbdsl; assert cbdsl.check('reachtouch', 'dexter') == []; "
        "print(sorted({'numpy', 'numba', 'pybullet', 'typer'} & {*sys.modules}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"


def test_findings_of_several_documents_are_given_once(here: Path) -> None:
    text = (ROOT / "programs" / "searchtrack.yaml").read_text("utf-8")
    for name in ("one", "two"):
        wrong = text.replace("name: searchtrack", f"name: {name}").replace("$eyes.uniform", "hed")
        (here / f"{name}.yaml").write_text(wrong, encoding="utf-8")
    diagnostics = cbdsl.check("one.yaml", Path("two.yaml"), "one.yaml")
    assert [(each.code, each.place.file) for each in diagnostics] == [
        ("CB501", "one.yaml"), ("CB501", "two.yaml"),
    ]  # fmt: skip
    with pytest.raises(cbdsl.UsageError, match="did you mean 'searchtrack'"):
        cbdsl.check("serchtrack")


def test_load_of_a_program_with_errors_raises_them(here: Path) -> None:
    (here / "bad.yaml").write_text("cbdsl: 1\nkind: program\nname: bad\n", encoding="utf-8")
    with pytest.raises(cbdsl.DiagnosticsError) as caught:
        cbdsl.load("bad.yaml")
    assert {each.code for each in caught.value.diagnostics} == {"CB203"}
    with pytest.raises(cbdsl.UsageError, match="policy or schema"):
        cbdsl.load("reachtouch", policy="reachtouch", schema="reachtouch")


def test_run_returns_one_result_per_episode_and_repeats_with_the_seed() -> None:
    ticks: list[Tick] = []
    first, second = cbdsl.run(
        "searchtrack", backend="kinematic", seed=SEED, episodes=2, on_tick=ticks.append
    )
    assert (first.seed, second.seed) == (SEED, SEED + 1)
    assert len(ticks) == first.ticks + second.ticks + 2
    with cbdsl.open_robot(cbdsl.load("searchtrack"), backend="kinematic") as robot:
        again = robot.run(SEED + 1)
        assert (again.predicates, again.ticks) == (second.predicates, second.ticks)
        with pytest.raises(cbdsl.UsageError, match="known: "):
            robot.run(SEED, context="nowhere")
    with pytest.raises(cbdsl.UsageError, match="did you mean 'kinematic'"):
        cbdsl.run("searchtrack", backend="kinematik")


def test_learning_writes_a_policy_that_runs_and_goes_on(here: Path) -> None:
    seen: list[int] = []
    for episodes, resume in ((2, False), (4, True)):
        learned = cbdsl.learn(
            "searchtrack", "new/mine.yaml", episodes=episodes, seed=5, backend="kinematic",
            constants={"epsilon": 0.3}, resume=resume, on_episode=lambda one: seen.append(one.seed),
        )  # fmt: skip
    assert len(seen) == len({*seen}) == 4
    assert [one.seed for one in learned.episodes] == seen
    assert learned.policy == here / "new" / "mine.yaml" and learned.policy in learned.files
    document = Library().read(learned.policy, PolicyDocument).document
    assert document.provenance is not None and document.provenance.episodes == 4
    assert document.provenance.command.startswith("cbdsl.learn(cbdsl.load('searchtrack', stage=")
    shutil.rmtree(here / "new")
    again = eval(document.provenance.command, {"cbdsl": cbdsl})
    assert again.episodes == learned.episodes
    request = cbdsl.load("searchtrack", policy=again.policy)
    (result,) = cbdsl.run(request, backend="kinematic", seed=SEED)
    assert result.rewarded
    with pytest.raises(cbdsl.UsageError, match="is there already"):
        cbdsl.learn("searchtrack", again.policy, backend="kinematic")
    with pytest.raises(cbdsl.UsageError, match="did you mean 'epsilon'"):
        cbdsl.learn("searchtrack", "other.yaml", backend="kinematic", constants={"epsilom": 1})
