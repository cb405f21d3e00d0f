"""Folders of recordings: nothing is written over unasked, nor by two at once, nor in part."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.runtime import recording_folder
from cbdsl.runtime.recording_folder import RecordingFolder


def test_folder_that_cannot_be_written_is_reported_beforehand(tmp_path: Path) -> None:
    RecordingFolder(tmp_path / "new").require_ready([0])
    assert not list((tmp_path / "new").iterdir())
    (tmp_path / "file").touch()
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(OSError):
            RecordingFolder(folder).require_ready([0])


@pytest.mark.parametrize("there", ["episode_7.json", "episode_7.npz"])
def test_existing_recording_is_replaced_only_on_request(there: str, tmp_path: Path) -> None:
    (tmp_path / there).write_text("kept")
    RecordingFolder(tmp_path).require_ready(range(7))
    with pytest.raises(UsageError, match=f"{there}.*--overwrite"):
        RecordingFolder(tmp_path).require_ready(range(8))
    with pytest.raises(UsageError, match=there), RecordingFolder(tmp_path).claim(7):
        pass
    RecordingFolder(tmp_path, overwrite=True).require_ready(range(8))
    with RecordingFolder(tmp_path, overwrite=True).claim(7):
        pass
    assert [file.name for file in tmp_path.iterdir()] == [there]


def test_recording_folder_is_locked_for_one_process(tmp_path: Path) -> None:
    one, other = RecordingFolder(tmp_path, overwrite=True), RecordingFolder(tmp_path)
    with one.claim(3):
        with pytest.raises(UsageError, match=r"another process.*seed 3"), other.claim(3):
            pass
        with other.claim(4):  # of another seed there is no quarrel
            pass
    with other.claim(3):
        pass
    assert not list(tmp_path.iterdir())


def test_claim_of_a_lock_that_was_removed_meanwhile_locks_the_next_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Open the lock file just before its holder removes it, and lock it just after."""
    one, other, third = (RecordingFolder(tmp_path, overwrite=True) for _ in range(3))
    holder = one.claim(3)
    holder.__enter__()
    original = recording_folder.lock

    def lock_after_release(file: BinaryIO) -> None:
        monkeypatch.setattr(recording_folder, "lock", original)
        holder.__exit__(None, None, None)
        original(file)

    monkeypatch.setattr(recording_folder, "lock", lock_after_release)
    with other.claim(3), pytest.raises(UsageError, match="another process"), third.claim(3):
        pass
    assert not list(tmp_path.iterdir())


def test_folder_with_a_linked_lock_is_refused_with_the_remedy(tmp_path: Path) -> None:
    (tmp_path / ".episode_7.lock").symlink_to(tmp_path / "mine")
    with pytest.raises(OSError, match="remove the link"):
        RecordingFolder(tmp_path, overwrite=True).require_ready([7])
    assert not (tmp_path / "mine").exists()
