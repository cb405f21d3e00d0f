"""Claims on functions that several processes need at once."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

from cbdsl.numeric import kernel_claim
from cbdsl.numeric.kernel_claim import claim, release

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
print(kernels.doubled(3.0), sum(kernels.doubled.stats.cache_hits.values()))
"""
HOLD = """
import sys, time
from pathlib import Path
from cbdsl.numeric.kernel_claim import claim
claim(Path(sys.argv[1]))
print("claimed", flush=True)
time.sleep(60)
"""


def start(command: str, *words: str, folder: Path | None = None) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-B", "-c", command, *words], cwd=folder, stdout=subprocess.PIPE, text=True
    )


def test_processes_at_once_compile_a_function_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    (tmp_path / "kernels.py").write_text(KERNELS, "utf-8")
    processes = [start(CALL, folder=tmp_path) for _ in range(3)]
    printed = sorted(process.communicate(timeout=120)[0].strip() for process in processes)
    assert printed == ["8.0 0", "8.0 1", "8.0 1"]
    assert [file.suffix for file in (tmp_path / "kept").iterdir()] == [".nbc"]


def test_killed_process_claims_nothing(tmp_path: Path) -> None:
    file = tmp_path / "kernel.nbc"
    with start(HOLD, str(file)) as other:
        assert other.stdout is not None and other.stdout.readline() == "claimed\n"
        other.kill()
    began = time.monotonic()
    claim(file)
    assert time.monotonic() - began < kernel_claim._PATIENCE / 10
    release(file)
    assert not list(tmp_path.iterdir())


def test_claim_of_a_living_process_is_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel_claim, "_PATIENCE", 0.2)
    file = tmp_path / "kernel.nbc"
    with start(HOLD, str(file)) as other:
        assert other.stdout is not None and other.stdout.readline() == "claimed\n"
        began = time.monotonic()
        claim(file)
        assert time.monotonic() - began >= 0.2
        other.kill()
    release(file)


def test_claims_of_one_process_do_not_wait_for_each_other(tmp_path: Path) -> None:
    file = tmp_path / "kernel.nbc"
    claim(file)
    claim(file)
    release(file)
    release(file)


def test_folder_without_a_right_to_write_is_no_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    claim(tmp_path / "file" / "kernel.nbc")
    release(tmp_path / "file" / "kernel.nbc")
