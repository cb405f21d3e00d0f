"""``cb warm``: functions that it compiles in advance, and folders that cannot keep them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from cbdsl.cli import warm
from cbdsl.control import potential_registry


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compile for few programs and few ticks."""
    monkeypatch.setattr(warm, "_PROGRAMS", ("reach",))
    monkeypatch.setattr(warm, "_TICKS", 2)
    monkeypatch.setattr(warm, "_TICKS_ON_ENGINES", 2)


@pytest.mark.usefixtures("short")
def test_warm_says_where_machine_code_is_kept(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(potential_registry, "compile_potentials", lambda: None)
    warm.warm()
    assert "functions compiled in" in capfd.readouterr().out


@pytest.mark.slow
def test_nothing_is_compiled_after_warm(tmp_path: Path) -> None:
    surroundings = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "kept")}
    script = "import sys; from cbdsl.cli.main import main; sys.argv[1:] = {!r}; main()"

    def cb(*words: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", script.format([*words])]
        done = subprocess.run(
            command, cwd=tmp_path, env=surroundings, capture_output=True, text=True, check=False
        )
        assert done.returncode in (0, 3, 4), done.stderr  # 3 and 4: the program did not succeed
        return done

    assert not cb("warm").stdout.startswith("0 functions")
    assert cb("warm").stdout.startswith("0 functions")
    programs = ("reachtouch", "bimanualtouch", "deliver", "touch_table", "stand", "visualinspect")
    for program in programs:
        assert "compiling" not in cb("run", program, "--backend", "kinematic").stderr
