"""Benchmarks: a missing peer is reported with the reason, and a missed target fails."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from cbdsl.documents.stage import StageDocument
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

FOLDER = ROOT / "benchmarks"
SCENE = json.dumps({"urdf": "none.urdf", "ready": [0.0]})
ASK = """
import sys
from pathlib import Path
import numpy
from peer_process import remote_peers
from peers import Scene
scene = Scene(Path("none.urdf"), numpy.zeros(1))
try:
    with remote_peers("nonesuch", sys.argv[1], scene):
        print("here")
except ImportError as error:
    print(error)
"""


def test_a_peers_process_says_why_it_has_none() -> None:
    run = subprocess.run(
        [sys.executable, str(FOLDER / "peer_process.py"), "nonesuch"],
        input=f"{SCENE}\n", capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert json.loads(run.stdout) == {"missing": "No module named 'nonesuch'"}


@pytest.mark.parametrize(
    ("python", "reason"),
    [
        (sys.executable, "No module named 'nonesuch'"),
        ("/nonesuch/python", "/nonesuch/python: No such file or directory"),
        ("/bin/true", "its process has ended with code 0"),
    ],
)
def test_a_missing_peer_has_a_reason(python: str, reason: str) -> None:
    run = subprocess.run(
        [sys.executable, "-c", ASK, python], cwd=FOLDER, capture_output=True, text=True
    )
    assert run.stdout.strip() == reason


JUDGES = (
    "scenes", "find_the_other", "touch_table", "hover_follow", "calibration", "success_rates",
    "episode_speed", "holding", "placing", "force", "gripper", "both_hands", "handover",
    "find_by_touch", "insertion", "claims",
)  # fmt: skip


def _benchmark(name: str, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(FOLDER))
    return importlib.import_module(name)


def _status(main: Callable[[], Any]) -> int:
    try:
        return int(main() or 0)
    except SystemExit as ended:
        return int(ended.code or 0)


@pytest.mark.parametrize("name", JUDGES)
def test_a_benchmark_takes_a_seed_and_a_number_of_episodes(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", [name, "--help"])
    assert _status(_benchmark(name, monkeypatch).main) == 0
    told = capsys.readouterr().out
    assert all(option in told for option in ("--seed ", "--episodes ", "--json"))


_FOUND = {"seed": 1, "rewarded": True, "in_turn": True, "seconds": 1.0, "ending": ""}
_TOUCHED = {"seed": 1, "rewarded": True, "seconds": 1.0, "in_contact": 3}
_FOLLOWED = {"seed": 1, "share": 1.0, "errors": [0.001]}


@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [
        ("find_the_other", _FOUND, {"rewarded": False}),
        ("find_the_other", _FOUND, {"in_turn": False}),
        ("touch_table", _TOUCHED, {"rewarded": False}),
        ("touch_table", _TOUCHED, {"in_contact": 0}),
        ("hover_follow", _FOLLOWED, {"share": 0.94}),
    ],
)
def test_a_benchmark_fails_where_its_target_is_missed(
    name: str, good: dict[str, Any], bad: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    module = _benchmark(name, monkeypatch)
    monkeypatch.setattr(sys, "argv", [name, "--json"])
    for row, status in ((good, 0), (good | bad, 1)):
        monkeypatch.setattr(module, "run_episodes", lambda *_, row=row: [row])
        assert _status(module.main) == status


@pytest.mark.parametrize(("right", "ghosts", "status"), [(98, 0, 0), (97, 0, 1), (100, 1, 1)])
def test_scenes_fail_by_positions_and_by_ghosts(
    right: int, ghosts: int, status: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenes = _benchmark("scenes", monkeypatch)
    outcomes = [scenes.Outcome(right, 100, ghosts > 0)]
    rig = SimpleNamespace(renderer="none", close=lambda: None)
    monkeypatch.setattr(scenes, "Rig", lambda *_: rig)
    monkeypatch.setattr(scenes, "_outcomes", lambda *_: outcomes)
    monkeypatch.setattr(sys, "argv", ["scenes", "--only", "in view", "--json"])
    assert _status(scenes.main) == status


def test_other_targets_are_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    rates = _benchmark("success_rates", monkeypatch)
    row = {"rewarded": True, "touching": 3, "fallen": False, "sim_seconds": 1.0, "seed": 1}
    row |= {"predicates": ["XXX"]}
    right, absent = (next(c for c in rates.CONDITIONS if c.name == n) for n in ("right", "absent"))
    assert rates.summarise(right, [row])["met"] and not rates.summarise(absent, [row])["met"]
    assert not rates.summarise(right, [row, row | {"rewarded": False}])["met"]
    speed = _benchmark("episode_speed", monkeypatch)
    summary = {"simulated_per_wall": 4.1, "percent": {"perception": 11.9}}
    assert not speed.misses(speed.BODIES[0], summary)
    assert speed.misses(speed.BODIES[0], summary | {"simulated_per_wall": 3.9})
    assert speed.misses(speed.BODIES[0], summary | {"percent": {"perception": 12.1}})
    calibration = _benchmark("calibration", monkeypatch)
    episode = {"seed": 1, "rewarded": True, "touching": 3, "last": "X11"}
    for changes, reached in (({}, True), ({"rewarded": False}, False), ({"touching": 2}, False)):
        rows = [{"body": 1, "before": [episode], "after": [episode | changes]}]
        assert calibration.summarise(rows)["reached"] == reached


_HELD = {
    "seed": 1, "taken": True, "kept": True, "lifted": 0.15, "carried": 0.25, "drift": 8.0,
    "tilt": 5.0, "force": 15.0, "seconds": 1.0, "ending": "",
}  # fmt: skip
_PLACED = {
    "seed": 1, "thing": "ball", "held": True, "placed": True, "reported": True, "false": False,
    "missed": False, "idle_ticks": 0, "error": 1.0, "tilt": 0.0, "seconds": 1.0, "ending": "",
}  # fmt: skip
_SLID = {"seed": 1, "good": True, "strayed": 0.2, "missed": 1.0, "ending": ""}
_LET_GO = {"seed": 1, "placed": True, "error": 1.0, "seconds": 1.0, "ending": ""}
_TAKEN = {
    "seed": 1, "rewarded": True, "untouched": 0, "lifted": True, "height": 0.1, "force": 10.0,
    "seconds": 1.0, "ending": "",
}  # fmt: skip
# Options before the episodes, and the allowed number of failures in 100.
_JUDGED = {
    "holding": (("ball",), (8.0,), _HELD),
    "placing": ((), (), _PLACED),
    "force": ((), (), _SLID),
    "gripper": ((), (), _LET_GO),
    "both_hands": (("ball",), (), _TAKEN),
}


@pytest.mark.parametrize(
    ("name", "bad", "most"),
    [
        ("holding", {"kept": False}, 3),
        ("holding", {"drift": 8.1}, 10),
        ("holding", {"tilt": 5.1}, 10),
        ("holding", {"force": 15.1}, 0),
        ("placing", {"placed": False}, 5),
        ("placing", {"false": True}, 0),
        ("placing", {"missed": True, "reported": False}, 2),
        ("force", {"good": False}, 5),
        ("gripper", {"placed": False}, 5),
        ("both_hands", {"rewarded": False}, 10),
        ("both_hands", {"untouched": 1}, 0),
    ],
)
def test_hands_fail_below_their_targets(
    name: str, bad: dict[str, Any], most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = _benchmark(name, monkeypatch)
    before, after, good = _JUDGED[name]
    for amiss, met in ((most, True), (most + 1, False)):
        rows = [good | bad] * amiss + [good] * (100 - amiss)
        episodes = [module.Episode(**row) for row in rows]
        assert module.summarise(*before, episodes, *after)["met"] == met


@pytest.mark.parametrize(("thing", "most"), [("ball", 5), ("cube", 10), ("cylinder", 10)])
def test_handovers_fail_below_their_targets(
    thing: str, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    handover = _benchmark("handover", monkeypatch)
    row = {"good": True, "from": "right", "reported": True, "true": True, "force": 1.0}
    for amiss, met in ((most, True), (most + 1, False)):
        rows = [row | {"good": False}] * amiss + [row] * (100 - amiss)
        assert handover.summarise(thing, rows)["met"] == met


@pytest.mark.parametrize(("clearance", "most"), [(10, 20), (20, 5), (2, 100)])
def test_insertions_fail_below_their_targets(
    clearance: int, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    insertion = _benchmark("insertion", monkeypatch)
    good = insertion.Insertion(1, True, 50.0, "")
    for amiss, met in ((most, True), (most + 1, False)):
        if amiss > 100:
            break
        trials = [good._replace(inside=False)] * amiss + [good] * (100 - amiss)
        assert insertion.summarise("box_in_box", clearance, trials)["met"] == met


def test_holes_leave_the_clearance_that_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    insertion = _benchmark("insertion", monkeypatch)
    library = Library(ROOT)
    pairs = library.read(library.locate(StageDocument, "pairs"), StageDocument).document
    for clearance, outer in ((0.01, 0.06), (0.02, 0.07)):
        tube, tray = (insertion.widened(pairs, clearance).things[name] for name in ("tube", "tray"))
        assert tube.form.radius == pytest.approx((outer, outer))
        assert tray.form.size == (*(pytest.approx((2 * outer,) * 2),) * 2, (0.1, 0.1))
    assert pairs.things["tube"].form.radius == (0.06, 0.06), "10 mm, as the stage has it"
