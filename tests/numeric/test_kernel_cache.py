"""Machine code that is kept for all environments of a user."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cbdsl.numeric import compiled, kernel_cache

KERNELS = """
from cbdsl.numeric.compiled import compiled, compiled_once

@compiled
def shifted(x):
    return x + 1.0

@compiled_once
def doubled(x):
    return 2.0 * shifted(x)
"""
CALL = """
import kernels
from cbdsl.numeric.kernel_cache import problem
print(kernels.doubled(3.0), sum(kernels.doubled.stats.cache_hits.values()), problem())
"""
LOAD = """
import kernels
from cbdsl.numeric.compiled import load_kept
print(load_kept(), load_kept(), kernels.doubled(3.0))
print(sum(kernels.doubled.stats.cache_hits.values()), kernels.doubled.signatures)
"""


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of machine code."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    return tmp_path / "kept"


def call(folder: Path, text: str = KERNELS, call: str = CALL) -> str:
    """Call the kernel in a process of its own, from the sources in a folder."""
    folder.mkdir(exist_ok=True)
    (folder / "kernels.py").write_text(text, encoding="utf-8")
    # Without bytecode: Python recognises an edited file by whole seconds and by its size.
    done = subprocess.run(
        [sys.executable, "-B", "-c", call], cwd=folder, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def test_another_environment_compiles_nothing(kept: Path, tmp_path: Path) -> None:
    calls = [call(tmp_path / name) for name in ("one", "other")]
    assert calls == ["8.0 0 None", "8.0 1 None"]
    (file,) = kept.iterdir()
    assert file.suffix == ".nbc"


def test_load_kept_leaves_nothing_to_the_first_call(kept: Path, tmp_path: Path) -> None:
    call(tmp_path / "one")
    assert call(tmp_path / "other", call=LOAD) == "1 0 8.0\n0 [(float64,)]"


def test_load_kept_compiles_nothing(kept: Path, tmp_path: Path) -> None:
    assert call(tmp_path / "one", call=LOAD).startswith("0 0 8.0")


@pytest.mark.parametrize(
    "content", [b"", b"no pickle", b"\x80\x04N."], ids=["empty", "text", "another object"]
)
def test_damaged_file_is_compiled_again(kept: Path, tmp_path: Path, content: bytes) -> None:
    call(tmp_path / "one")
    (file,) = kept.iterdir()
    file.write_bytes(content)
    calls = [call(tmp_path / "one") for _ in range(2)]
    assert calls == ["8.0 0 None", "8.0 1 None"]


def test_folder_that_cannot_be_written_is_a_problem_and_no_error(
    kept: Path, tmp_path: Path
) -> None:
    kept.write_text("in the way", encoding="utf-8")
    assert call(tmp_path / "one").startswith(f"8.0 0 {kept}: ")
    assert kept.read_text("utf-8") == "in the way"


def test_another_version_of_a_library_has_files_of_its_own(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fresh() -> int:
        kernel_cache._surroundings.cache_clear()
        kernel = compiled.compiled_once(halved)
        assert kernel(6.0) == 3.0
        return sum(kernel.stats.cache_hits.values())  # type: ignore[attr-defined]

    hits = [fresh(), fresh()]
    monkeypatch.setattr(kernel_cache.numba, "__version__", "0.0.1")
    hits += [fresh(), fresh()]
    monkeypatch.undo()
    kernel_cache._surroundings.cache_clear()
    assert hits == [0, 1, 0, 1]
    assert len([*kept.iterdir()]) == 2


def halved(x: float) -> float:
    return x / 2.0


def test_files_that_are_not_used_for_long_are_deleted(kept: Path, tmp_path: Path) -> None:
    kept.mkdir()
    for name, days in (("old", 100), ("used", 10)):
        (kept / name).touch()
        os.utime(kept / name, (0, time.time() - days * 24 * 3600))
    call(tmp_path / "one")
    assert {file.name.partition("-")[0] for file in kept.iterdir()} == {"used", "doubled"}


def test_use_is_noted(kept: Path, tmp_path: Path) -> None:
    call(tmp_path / "one")
    (file,) = kept.iterdir()
    os.utime(file, (0, time.time() - 10 * 24 * 3600))
    call(tmp_path / "one")
    assert time.time() - file.stat().st_mtime < 24 * 3600


@pytest.mark.parametrize(
    ("variables", "place"),
    [
        ({"HOME": "/home/a"}, "/home/a/.cache/cbdsl/kernels"),
        ({"HOME": "/home/a", "XDG_CACHE_HOME": "/var/b"}, "/var/b/cbdsl/kernels"),
        ({"HOME": "/home/a", "XDG_CACHE_HOME": "relative"}, "/home/a/.cache/cbdsl/kernels"),
        ({"HOME": "/home/a", "NUMBA_CACHE_DIR": "/tmp/c"}, "/tmp/c"),
        ({"HOME": ""}, None),
    ],
)
def test_folder_is_below_the_users_caches(
    monkeypatch: pytest.MonkeyPatch, variables: dict[str, str], place: str | None
) -> None:
    for name in ("HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert kernel_cache.folder() == (None if place is None else Path(place))


def test_uncompiled_leaves_out_kept_functions(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "_kernels", [])
    assert compiled.uncompiled() == frozenset()
    kernel = compiled.compiled_once(halved)
    assert compiled.uncompiled() == {halved}
    assert kernel(6.0) == 3.0
    again = compiled.compiled_once(halved)
    assert again is not kernel and compiled.uncompiled() == frozenset()
    shutil.rmtree(kept)
    assert compiled.uncompiled() == {halved}
