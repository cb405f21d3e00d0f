"""Tests of ``cb learn --from`` a policy or a schema that another robot learned."""

from __future__ import annotations

import importlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.cli.test_main import cb
from tests.conftest import ROOT

SOURCE = ROOT / "benchmarks" / "transfer" / "programs"
KINEMATIC = ("--backend", "kinematic", "--seed", "1")
# Drawing samples makes the program one with an internal model of the hand.
SEARCH = (
    "  search: {potential: spring, reference: $hand.uniform, feedback: $hand, effector: $hand}\n"
)
CB = Callable[..., int]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> CB:
    """Return ``cb`` in a folder with two Pandas, the program, and a policy that a Panda learned."""
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    importlib.import_module("two_pandas").write_two_pandas(ROOT / "robots", tmp_path / "robots")
    shutil.copytree(SOURCE, tmp_path / "programs")
    program = tmp_path / "programs" / "close_on.yaml"
    text = program.read_text("utf-8").replace("\nbackground:", f"{SEARCH}\nbackground:")
    program.write_text(
        text.replace("actions: [", "actions: [search, ").replace('"**"', '"***"'), "utf-8"
    )
    monkeypatch.chdir(tmp_path)

    def call(*words: str) -> int:
        return cb(monkeypatch, *words)

    learn = ("learn", "close_on", "--robot", "panda", *KINEMATIC, "--episodes", "1")
    assert call(*learn, "--out", "on_panda.yaml") == 0
    learned = read("on_panda.yaml")
    learned["policy"] = {"***": "reach ◁ touch"}
    Path("on_panda.yaml").write_text(yaml.safe_dump(learned, allow_unicode=True), "utf-8")
    return call


def read(name: str) -> Any:
    return yaml.safe_load(Path(name).read_text("utf-8"))


def transfer(run: CB, out: str, episodes: int = 4, source: str = "on_panda") -> int:
    return run(
        "learn", "close_on", "--robot", "two_pandas", "--from", source, "--stage", "whole_bench",
        *KINEMATIC, "--episodes", str(episodes), "--out", out,
    )  # fmt: skip


def test_transfer_keeps_the_policy_and_learns_allocations_and_models(
    run: CB, capsys: pytest.CaptureFixture[str]
) -> None:
    assert transfer(run, "on_two.yaml", 8) == 0
    schema, policy = read("on_two.yaml"), read("on_panda.yaml")
    assert schema["policy"] == policy["name"]
    assert schema["allocations"].keys() == {"left_arm", "right_arm"}
    hands = {f"{side}_hand.uniform": f"on_two_{side}_hand" for side in ("left", "right")}
    assert schema["models"] and schema["models"].items() <= hands.items()
    provenance = schema["provenance"]
    assert provenance["origin"] == policy["provenance"]["robot"]
    assert provenance["robot"]["name"] == "two_pandas" and "on_panda" in provenance["policies"]
    assert run("validate", "on_two.yaml", "on_panda.yaml") == 0
    capsys.readouterr()
    shown = ("run", "close_on", "--robot", "two_pandas", "--schema", "on_two", *KINEMATIC, "--json")
    assert run(*shown, "--stage", "whole_bench", "--episodes", "5") == 0
    episodes = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert sum(each["rewarded"] for each in episodes) >= 3
    assert any(action.endswith(" with left_arm") for each in episodes for action in each["actions"])


def test_transfer_resumes_to_the_same_schema(run: CB) -> None:
    assert transfer(run, "once.yaml", 3) == 0
    assert transfer(run, "again.yaml", 1) == 0
    words = ("learn", "close_on", "--robot", "two_pandas", "--from", "on_panda")
    rest = ("--stage", "whole_bench", *KINEMATIC, "--episodes", "3", "--out", "again.yaml")
    assert run(*words, *rest, "--resume") == 0
    assert Path("once.yaml").read_text().replace("once", "again") == Path("again.yaml").read_text()


def test_policy_of_another_robot_runs_without_its_models(run: CB) -> None:
    words = ("run", "close_on", "--policy", "on_panda", *KINEMATIC)
    assert run(*words, "--robot", "two_pandas") == 0
    assert run(*words, "--robot", "panda") == 0


def test_single_allocation_learns_where_reward_is_likely(run: CB) -> None:
    for suffix in ("yaml", "urdf"):
        shutil.copy(ROOT / "robots" / f"panda.{suffix}", f"robots/panda.{suffix}")
    text = Path("robots/panda.yaml").read_text("utf-8").replace("name: panda", "name: franka")
    Path("robots/franka.yaml").write_text(text, "utf-8")
    words = ("learn", "close_on", "--robot", "franka", "--from", "on_panda", *KINEMATIC)
    assert run(*words, "--episodes", "4", "--out", "on_franka.yaml") == 0
    schema = read("on_franka.yaml")
    assert schema["choose"] == "arm" and schema["allocations"].keys() == {"arm"}
    rewarded = sum(schema["curve"]["reward"])
    assert schema["reward"] == pytest.approx((rewarded + 1) / 6, abs=1e-3)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("close_on", "--robot", "panda", "--from", "on_panda"), "'panda' has learned this itself"),
        (("close_on", "--robot", "two_pandas", "--from", "on_two"), "'two_pandas' has learned"),
        (("close_on", "--robot", "panda", "--from", "reachtouch"), "serves program 'reachtouch'"),
        (("close_on", "--robot", "panda", "--from", "on_pand"), "did you mean 'on_panda'"),
        (("close_on", "--robot", "desk", "--from", "on_panda"), "no effector of force for role"),
        (
            ("bimanualtouch", "--robot", "panda", "--from", "bimanualtouch"),
            "for robot 'dexter' alone",
        ),
        (("close_on", "--robot", "panda", "--learner", "transfer"), "and none is named"),
        (
            ("close_on", "--robot", "two_pandas", "--from", "on_panda", "--out", "far/it.yaml"),
            "does not find its policy 'on_panda'",
        ),
    ],
)
def test_unsuitable_source_of_a_transfer_is_one_problem(
    words: tuple[str, ...], message: str, run: CB, capsys: pytest.CaptureFixture[str]
) -> None:
    if "on_two" in words:
        assert transfer(run, "on_two.yaml", 1) == 0
    Path("far").mkdir()
    before = sorted(Path().iterdir())
    capsys.readouterr()
    out = () if "--out" in words else ("--out", "it.yaml")
    assert run("learn", *words, *out, "--backend", "kinematic") in (1, 2)
    shown = capsys.readouterr()
    assert (shown.out + shown.err).count(message) == 1
    assert sorted(Path().iterdir()) == before


def test_schema_of_another_robot_is_one_finding(
    run: CB, capsys: pytest.CaptureFixture[str]
) -> None:
    assert transfer(run, "on_two.yaml", 1) == 0
    capsys.readouterr()
    assert run("run", "close_on", "--robot", "panda", "--schema", "on_two", *KINEMATIC) == 1
    shown = capsys.readouterr()
    assert (shown.out + shown.err).count("CB646") == 1
    shutil.rmtree("robots")
    assert run("validate", "on_two.yaml") == 1
    shown = capsys.readouterr()
    assert "which is not at hand" in shown.out + shown.err
