"""Atomic writes: whole files or the old ones, and no device is replaced."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from cbdsl.storage.atomic_file import make_room, remove_leftovers, replace_file, write_text
from tests.full_disk import no_file_beyond


def test_failed_write_names_its_file_and_keeps_the_old_one(tmp_path: Path) -> None:
    path = tmp_path / "file"
    replace_file(path, lambda file: file.write(b"before"))
    with pytest.raises(OSError) as caught, no_file_beyond(100):
        replace_file(path, lambda file: file.write(b"x" * 200_000))
    assert caught.value.filename == str(path) and caught.value.strerror
    assert [file.read_bytes() for file in tmp_path.iterdir()] == [b"before"]


def test_device_is_never_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(OSError, match="a device, not a file"):
        make_room(pipe)
    with pytest.raises(OSError, match="a device, not a file"):
        write_text("new", pipe)
    assert pipe.is_fifo() and list(tmp_path.iterdir()) == [pipe]


def test_leftovers_of_killed_writers_are_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, other = tmp_path / "[a].yaml", tmp_path / "[a].yaml.yaml"
    with monkeypatch.context() as patch:
        # A killed process leaves its temporary file.
        patch.setattr(os, "replace", lambda *_: None)
        for file in (path, path, other):
            write_text("half", file)
    assert len(list(tmp_path.iterdir())) == 3
    remove_leftovers(path)
    (left,) = tmp_path.iterdir()
    assert left.name.startswith(".[a].yaml.yaml")
