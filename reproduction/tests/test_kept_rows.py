"""Kept rows: written one by one, each on a line of its own."""

from __future__ import annotations

from pathlib import Path

from cbdsl_reproduction.kept_rows import KeptRows


def test_added_row_can_be_read_immediately(tmp_path: Path) -> None:
    path = tmp_path / "folder" / "rows.jsonl"
    rows = KeptRows(path)
    assert list(rows) == []
    rows.add({"a": 1})
    rows.add([2, "ü"])
    assert list(KeptRows(path)) == [{"a": 1}, [2, "ü"]]
    assert len(path.read_text(encoding="utf-8").splitlines()) == 2


def test_truncated_row_is_dropped_and_others_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    path.write_text('[1]\n[2, {"cut', encoding="utf-8")
    rows = KeptRows(path)
    assert list(rows) == [[1]]
    rows.add([3])
    assert list(rows) == [[1], [3]]
