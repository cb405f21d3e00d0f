"""Journals: complete lines are resumed, differences and damage are reported, one writer each."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cbdsl.storage.file_lock import lock
from cbdsl.storage.journal import (
    DamagedJournalError,
    Journal,
    JournalError,
    RowForm,
    require_same,
    require_usable,
    rows_of,
)
from cbdsl.storage.journal_follower import JournalFollower

IDENTITY = {"cbdsl": 1, "seed": 5}
PLAIN = RowForm[dict[str, Any]]("trial", "a row", dict, dict)


def test_journal_goes_on_after_its_last_whole_line(tmp_path: Path) -> None:
    path = tmp_path / "some.jsonl"
    with Journal(path, IDENTITY, PLAIN) as journal:
        assert (journal.path, journal.rows) == (path, [])
        journal.append({"name": "Wärme"})
    with path.open("ab") as file:
        file.write(b'{"name": "half a li')
    with Journal(path, IDENTITY, PLAIN) as journal:
        assert journal.rows == [{"name": "Wärme"}]
        journal.append({"name": "b"})
    assert path.read_text() == '{"cbdsl": 1, "seed": 5}\n{"name": "Wärme"}\n{"name": "b"}\n'
    assert path.stat().st_mode & 0o777 == 0o644


def _sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(6 << 30)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (os.mkfifo, "is a named pipe, no journal"),
        (lambda path: path.symlink_to("/dev/zero"), "is a link"),
        (lambda path: path.symlink_to("missing"), "is a link"),
        (lambda path: path.mkdir(), "is a folder"),
        (_sparse, "is no journal; remove it"),
        (lambda path: path.write_text("notes without a line break"), "is no journal; remove it"),
    ],
)
def test_journal_in_the_place_of_something_else_is_refused(
    make: Callable[[Path], object], said: str, tmp_path: Path
) -> None:
    path = tmp_path / "some.jsonl"
    make(path)
    before = path.lstat()
    for read in (
        lambda: Journal(path, IDENTITY, PLAIN),
        lambda: require_usable(path, IDENTITY),
        lambda: JournalFollower(path, PLAIN).poll(),
    ):
        with pytest.raises(JournalError, match=said):
            read()
    assert path.lstat().st_size == before.st_size


def test_journal_of_another_trial_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "some.jsonl"
    Journal(path, IDENTITY, PLAIN).close()
    before = path.read_bytes()
    with pytest.raises(JournalError, match="belongs to another gauge: seed was 5, is 6; ask for"):
        Journal(path, {**IDENTITY, "seed": 6}, replace(PLAIN, undertaking="gauge"))
    assert path.read_bytes() == before
    with path.open("rb") as file:
        lock(file)  # a refused process does not hold the lock


@pytest.mark.parametrize(
    ("known", "wanted", "said"),
    [
        ({"a": 1}, {"a": 1, "b": 2}, "b was nothing, is 2"),
        ({"a": [1, 2]}, {"a": [1]}, "a was 1, 2, is 1"),
        ({"a": {"name": "one"}}, {"a": {"name": "two"}}, "a was one, is two"),
        ({"a": {"name": "one"}}, {"a": None}, "a was one, is nothing"),
        ({"a": 3}, {"a": {"x": 1}}, "a was 3, is {'x': 1}"),
        (
            {"stage": {"name": "table", "sha256": "0"}},
            {"stage": {"name": "table", "sha256": "1"}},
            "stage 'table' has changed since",
        ),
        ({"a": {"x": 1, "y": 2, "z": 3}}, {"a": {"x": 1, "y": 3}}, "y was 2, is 3; z was 3, is"),
    ],
)
def test_journal_of_another_trial_names_the_difference(
    known: dict[str, Any], wanted: dict[str, Any], said: str
) -> None:
    with pytest.raises(JournalError, match=rf"some\.jsonl belongs to another trial: {said}"):
        require_same(Path("some.jsonl"), known, wanted)
    require_same(Path("some.jsonl"), known, known)


def test_lines_are_read_up_to_the_last_end_of_one() -> None:
    path = Path("some.jsonl")
    assert rows_of(b'{"a": 1}\n{"b": 2}\n{"c"', path) == ([{"a": 1}, {"b": 2}], 18)
    assert rows_of(b'{"a": 1', path) == ([], 0)


@pytest.mark.parametrize(
    ("data", "problem"),
    [(b"[1]\n", "not a JSON object"), (b"{\n", r"not JSON \("), (b"\n", "not JSON")],
)
def test_damaged_line_is_reported_with_the_remedy(data: bytes, problem: str) -> None:
    path = Path("my trial.jsonl")
    with pytest.raises(
        DamagedJournalError, match=f"not a journal of a trial: of line 1, it is {problem}"
    ):
        rows_of(data, path)
    with pytest.raises(DamagedJournalError, match=f"line 2: it is {problem}") as raised:
        rows_of(b"{}\n" + data, path)
    assert str(raised.value).endswith(
        "with --resume where it has that, after: mv 'my trial.jsonl' 'my trial.jsonl.damaged' "
        "&& head -n 1 'my trial.jsonl.damaged' > 'my trial.jsonl'"
    )
    with pytest.raises(DamagedJournalError, match=r"line 7: .* goes on there, after"):
        rows_of(data, path, "calibration", 7)
