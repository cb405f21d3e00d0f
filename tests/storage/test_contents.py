"""Contents of files: special files and files above the bound are refused before they are read."""

from __future__ import annotations

import errno
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from cbdsl.storage.contents import contents


def refused(path: Path, most: int = 10) -> OSError:
    with pytest.raises(OSError) as caught:
        contents(path, most)
    return caught.value


def test_file_is_read_whole_up_to_its_bound(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"0123456789")
    assert contents(path, 10) == b"0123456789"
    assert refused(path, 9).errno == errno.EFBIG


def test_path_without_a_regular_file_is_reported_by_its_kind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # a socket's path has to be short
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind("socket")
    assert refused(tmp_path / "socket").strerror == "it is a socket"
    assert refused(tmp_path).strerror == "it is a folder"
    assert refused(Path("/dev/zero")).strerror == "it is a device"


def test_pipe_without_a_writer_does_not_block(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    program = (
        "import sys; from pathlib import Path; from cbdsl.storage.contents import contents\n"
        "try: contents(Path(sys.argv[1]), 10)\n"
        "except OSError as error: print(error.strerror)"
    )
    run = [sys.executable, "-c", program, str(tmp_path / "pipe")]
    said = subprocess.run(run, capture_output=True, text=True, timeout=60, check=True).stdout
    assert said == "it is a named pipe\n"


def test_broken_link_is_reported_with_its_target(tmp_path: Path) -> None:
    (tmp_path / "lost").symlink_to("gone.yaml")
    (tmp_path / "loop").symlink_to("loop")
    assert refused(tmp_path / "lost").strerror == "it is a link to gone.yaml, which is not there"
    assert refused(tmp_path / "loop").errno == errno.ELOOP
    assert refused(tmp_path / "none").errno == errno.ENOENT


def test_file_of_unknown_size_is_bounded_as_well() -> None:
    # Files of the kernel report a size of zero.
    assert contents(Path("/proc/self/status"), 1_000_000)
    assert refused(Path("/proc/self/status"), 10).errno == errno.EFBIG
