"""The notice of compilation: printed once, and only while a command waits for the compiler."""

from __future__ import annotations

import pytest
from numba import njit

from cbdsl.cli.output import compilation
from cbdsl.cli.output.compilation import NOTICE, told_of_compilation


@pytest.fixture(autouse=True)
def _new_process() -> None:
    compilation._announce.cache_clear()
    compilation._report.cache_clear()


def test_first_function_that_is_compiled_is_reported(
    capsys: pytest.CaptureFixture[str],
) -> None:
    functions = [njit(lambda x, plus=plus: x + plus) for plus in (1, 2)]
    with told_of_compilation():
        assert [function(1) for function in functions] == [2, 3]
    assert capsys.readouterr().err == f"{NOTICE}\n"
    with told_of_compilation():
        assert [function(1) for function in functions] == [2, 3]
    assert njit(lambda x: x)(1) == 1  # outside of the context there is no notice
    assert capsys.readouterr() == ("", "")


def test_code_that_cannot_be_kept_is_reported_once(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compilation, "problem", lambda: "/kept: Read-only file system")
    for plus in (1, 2):
        with told_of_compilation():
            assert njit(lambda x, plus=plus: x + plus)(1) == 1 + plus
    expected = (
        "compiled code cannot be kept (/kept: Read-only file system), so every run compiles again; "
        "NUMBA_CACHE_DIR names another folder"
    )
    lines = capsys.readouterr().err.splitlines()
    assert lines == [NOTICE, expected]
