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


@pytest.mark.parametrize("is_relative", [True, False])
def test_write_text_through_a_symbolic_link_keeps_the_link(
    is_relative: bool, tmp_path: Path
) -> None:
    elsewhere, link = tmp_path / "shared" / "x.yaml", tmp_path / "knowledge" / "x.yaml"
    link.parent.mkdir()
    link.symlink_to(Path("../shared/x.yaml") if is_relative else elsewhere)
    make_room(link, follow=True)
    for text in ("created through the link", "replaced through the link"):
        write_text(text, link, follow=True)
        assert link.is_symlink() and elsewhere.read_text("utf-8") == text
    assert [file.name for file in elsewhere.parent.iterdir()] == ["x.yaml"]
    (elsewhere.parent / ".x.yaml.unfinished-1").touch()
    remove_leftovers(link)
    assert [file.name for file in elsewhere.parent.iterdir()] == ["x.yaml"]


def test_write_text_without_following_refuses_a_symbolic_link(tmp_path: Path) -> None:
    link = tmp_path / "link"
    for target in (tmp_path / "there", tmp_path / "missing"):
        (tmp_path / "there").write_text("mine", encoding="utf-8")
        link.unlink(missing_ok=True)
        link.symlink_to(target)
        for write in (make_room, lambda path: write_text("theirs", path)):
            with pytest.raises(OSError, match=r"is a link to .*remove the link"):
                write(link)
    assert (tmp_path / "there").read_text("utf-8") == "mine"
    assert not (tmp_path / "missing").exists()


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_write_text_creates_a_file_with_the_permissions_of_the_mask(
    mask: int, tmp_path: Path
) -> None:
    before = os.umask(mask)
    try:
        write_text("new", tmp_path / "new")
    finally:
        os.umask(before)
    assert (tmp_path / "new").stat().st_mode & 0o777 == 0o666 & ~mask


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755])
def test_write_text_keeps_the_permissions_of_an_existing_file(mode: int, tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.touch()
    path.chmod(mode)
    write_text("new", path)
    assert path.stat().st_mode & 0o777 == mode
