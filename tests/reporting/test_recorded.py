"""Invalid, old and incomplete recordings, which are refused with one sentence."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.reporting.recorded import find_recordings, read_recording


def rewrite(file: Path, change: Callable[[dict[str, Any]], object]) -> None:
    """Change the content of the JSON file."""
    summary = json.loads(file.read_text("utf-8"))
    change(summary)
    file.write_text(json.dumps(summary), encoding="utf-8")


def without(file: Path, *keys: str, ticks: int | None = None) -> None:
    """Remove arrays from the NPZ file, or the last ticks of all arrays."""
    with np.load(file) as loaded:
        arrays = {key: loaded[key][:ticks] for key in loaded if key not in keys}
    np.savez_compressed(file, **arrays)


def changed(file: Path, **changes: Callable[[Any], Any]) -> None:
    """Change arrays of the NPZ file."""
    with np.load(file) as loaded:
        arrays = {key: loaded[key] for key in loaded}
    arrays |= {key: change(arrays[key]) for key, change in changes.items()}
    np.savez_compressed(file, **arrays)


def spoil_bytes(file: Path) -> None:
    """Overwrite bytes in the middle of the compressed data."""
    data = bytearray(file.read_bytes())
    data[60:160] = bytes(100)
    file.write_bytes(data)


PART = {
    "shape": "ball",
    "size": [0.1],
    "position": [0.0] * 3,
    "quaternion": [0.0, 0.0, 0.0, 1.0],
    "color": [1.0] * 3,
}


def with_mesh(corners: list[Any], triangles: list[Any]) -> Callable[[dict[str, Any]], None]:
    """Return a function that adds an object with this mesh to the scene."""

    def add(summary: dict[str, Any]) -> None:
        mesh = {"corners": corners, "triangles": triangles}
        summary["scene"]["odd"] = [PART | {"shape": "mesh", "mesh": mesh}]

    return add


def with_part(**changes: Any) -> Callable[[dict[str, Any]], None]:
    """Return a function that adds an object with this part to the scene."""

    def add(summary: dict[str, Any]) -> None:
        summary["scene"]["odd"] = [PART | changes]

    return add


def old(summary: dict[str, Any]) -> None:
    for key in ("cbdsl", "kind", "version", "members", "triples"):
        del summary[key]


SPOILED: dict[str, tuple[Callable[[Path], object], str]] = {
    "killed between the files": (lambda file: file.unlink(), "cut short"),
    "arrays not copied": (lambda file: file.with_suffix(".npz").unlink(), "two files"),
    "half of the text": (
        lambda file: file.write_text(file.read_text("utf-8")[:999], encoding="utf-8"),
        "cut short",
    ),
    "half of the arrays": (
        lambda file: file.with_suffix(".npz").write_bytes(
            file.with_suffix(".npz").read_bytes()[:5000]
        ),
        "damaged",
    ),
    "empty arrays": (lambda file: file.with_suffix(".npz").write_bytes(b""), "damaged"),
    "something else": (lambda file: file.write_text("[1, 2]", encoding="utf-8"), "no recording"),
    "part of an unknown shape": (
        lambda file: rewrite(file, with_part(shape="cone")),
        "scene.odd.0.shape",
    ),
    "part with too many sizes": (
        lambda file: rewrite(file, with_part(size=[0.1, 0.2])),
        "2 sizes instead of 1",
    ),
    "part without a place": (
        lambda file: rewrite(file, with_part(position=[])),
        "scene.odd.0.position",
    ),
    "references of another robot": (
        lambda file: changed(file.with_suffix(".npz"), references=lambda rows: rows[:, :2]),
        "references: has the shape",
    ),
    "not text": (lambda file: file.write_bytes(b"\x89PNG\x00\xff"), "no recording"),
    "older": (lambda file: rewrite(file, old), "older cb"),
    "newer": (lambda file: rewrite(file, lambda s: s.update(version=99)), "version 99"),
    "no robot": (lambda file: rewrite(file, lambda s: s.pop("robot")), "lacks robot"),
    "a robot that is none": (
        lambda file: rewrite(file, lambda s: s["robot"].update(urdf="<robot></link>")),
        "damaged .*not XML",
    ),
    "a coupling to nothing": (
        lambda file: rewrite(file, lambda s: s["robot"]["couplings"].update(wing=["tail", 1])),
        r"damaged \(robot.couplings.wing",
    ),
    "another kind of seed": (
        lambda file: rewrite(file, lambda s: s["result"].update(seed=[3])),
        r"damaged \(result.seed: input should be a valid integer",
    ),
    **{
        f"a transition without its {key}": (
            lambda file, key=key: rewrite(file, lambda s: s["transitions"][0].pop(key)),
            rf"damaged \(transitions.0.{key}: field required",
        )
        for key in ("program", "depth", "time", "state", "action", "next_state", "reward")
    },
    "a transition at a word": (
        lambda file: rewrite(file, lambda s: s["transitions"][0].update(time="soon")),
        r"damaged \(transitions.0.time: input should be a valid number",
    ),
    "a letter too few": (
        lambda file: rewrite(file, lambda s: s["predicates"].__setitem__(0, "0")),
        "one letter for each controller",
    ),
    "triples of others": (
        lambda file: rewrite(file, lambda s: s["triples"].clear()),
        "triples: are not those",
    ),
    "a triangle without a corner": (
        lambda file: rewrite(file, with_mesh([[0, 0, 0]], [[0, 0, 1]])),
        "a triangle without a corner",
    ),
    "a flat mesh": (
        lambda file: rewrite(file, with_mesh([[0, 0]], [[0, 0, 0]])),
        "other than three numbers",
    ),
    "a joint too many": (
        lambda file: rewrite(file, lambda s: s["joints"].append("tail")),
        r"damaged \((positions|velocities|references|at_limits): has the shape",
    ),
    "held by nobody": (
        lambda file: changed(file.with_suffix(".npz"), level_held_by=lambda a: a + 99),
        "level_held_by: names a controller",
    ),
    "held from below": (
        lambda file: changed(file.with_suffix(".npz"), level_held_by=lambda a: a - 99),
        "level_held_by: names a controller",
    ),
    "another sight": (
        lambda file: changed(file.with_suffix(".npz"), sight=lambda a: a + 99),
        "sight: names a kind of sight",
    ),
    "a transition of another program": (
        lambda file: rewrite(file, lambda s: s["transitions"][0].update(program="other")),
        "transitions: have not one letter for each member",
    ),
    "a tip on another link": (
        lambda file: rewrite(file, lambda s: s["robot"]["tips"]["right_arm"].update(link="tail")),
        r"damaged \(robot.tips.right_arm",
    ),
    "words for numbers": (
        lambda file: changed(file.with_suffix(".npz"), time=lambda a: a.astype(str)),
        r"damaged \(time: is of <U",
    ),
    "a byte of an archive": (lambda file: spoil_bytes(file.with_suffix(".npz")), "damaged"),
    "deeply nested": (
        lambda file: file.write_text("[" * 100_000, encoding="utf-8"),
        "no recording",
    ),
    "no levels": (
        lambda file: without(file.with_suffix(".npz"), "level_share"),
        "lacks level_share",
    ),
    "no signal": (
        lambda file: without(file.with_suffix(".npz"), "signal_stereo.sat_10"),
        "lacks signal_stereo.sat_10",
    ),
    "of two episodes": (
        lambda file: without(file.with_suffix(".npz"), ticks=5),
        "same episode",
    ),
}


@pytest.mark.parametrize("how", SPOILED)
def test_spoiled_recording_is_refused(how: str, kept: Path, tmp_path: Path) -> None:
    for suffix in (".json", ".npz"):
        shutil.copy(kept.with_suffix(suffix), tmp_path)
    file = tmp_path / kept.name
    spoil, named = SPOILED[how]
    spoil(file)
    with pytest.raises(UsageError, match=named) as caught:
        read_recording(file)
    assert str(tmp_path) in str(caught.value)


def test_either_file_or_the_folder_finds_it(kept: Path) -> None:
    for path in (kept, kept.with_suffix(".npz"), kept.parent):
        assert find_recordings(path) == [kept]


def test_recordings_of_a_folder_are_sorted_by_seed(tmp_path: Path) -> None:
    for name in ("episode_10.json", "episode_9.json", "episode_11.npz", "notes.json"):
        (tmp_path / name).touch()
    found = [file.name for file in find_recordings(tmp_path)]
    assert found == ["episode_9.json", "episode_10.json", "episode_11.json"]


@pytest.mark.parametrize("name", ["", "episode_1.json"])
def test_recording_that_is_a_named_pipe_is_refused_by_its_kind(name: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "episode_1.json")
    with pytest.raises(UsageError, match="it is a named pipe"):
        read_recording(*find_recordings(tmp_path / name))


def test_folder_without_recordings_is_reported(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="when an episode ends"):
        find_recordings(tmp_path)
    with pytest.raises(UsageError, match="no such file"):
        find_recordings(tmp_path / "none")
