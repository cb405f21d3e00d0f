"""Contract of exports: a target that is complete or absent, and errors with a cause."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cbdsl.cli.main import build_app
from cbdsl.diagnostics.errors import UsageError
from cbdsl.reporting.export_format import EXPORTS
from cbdsl.reporting.recorded import Recorded, read_recording

EXPORT = pytest.mark.parametrize("name", EXPORTS.usable_names())


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    """Record a motion of Dexter."""
    folder = tmp_path_factory.mktemp("recording")
    words = ["run", "posture", "--backend", "kinematic", "--seed", "3", "--record", str(folder)]
    assert CliRunner().invoke(build_app(["run"]), words).exit_code == 0
    return read_recording(folder / "episode_3.json")


def _target(name: str, folder: Path) -> Path:
    return folder / f"target{EXPORTS.get(name).suffix}"


@EXPORT
def test_export_writes_its_target_and_describes_it(
    name: str, recorded: Recorded, tmp_path: Path
) -> None:
    target = _target(name, tmp_path)
    contents = EXPORTS.get(name).write([recorded], target)
    assert contents and "\n" not in contents and not contents.endswith(".")
    assert [*tmp_path.iterdir()] == [target]
    assert target.is_file() == bool(EXPORTS.get(name).suffix)


@EXPORT
def test_export_to_a_file_as_folder_is_refused(
    name: str, recorded: Recorded, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("kept")
    with pytest.raises((OSError, UsageError)):
        EXPORTS.get(name).write([recorded], _target(name, tmp_path / "file"))
    assert (tmp_path / "file").read_text() == "kept"


@EXPORT
def test_export_without_its_last_recording_leaves_no_target(
    name: str, recorded: Recorded, tmp_path: Path
) -> None:
    def broken() -> Iterator[Recorded]:
        if EXPORTS.get(name).folder:
            yield recorded
        raise UsageError("the next recording is damaged")

    with pytest.raises(UsageError, match="damaged"):
        EXPORTS.get(name).write(broken(), _target(name, tmp_path))
    assert not _target(name, tmp_path).exists()
