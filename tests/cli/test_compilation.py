"""The notice of compilation: printed once, and only while a command waits for the compiler."""

from __future__ import annotations

import pytest
from numba import njit

from cbdsl.cli.compilation import NOTICE, told_of_compilation


def test_the_first_function_that_is_compiled_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    functions = [njit(lambda x, plus=plus: x + plus) for plus in (1, 2)]
    with told_of_compilation():
        assert [function(1) for function in functions] == [2, 3]
    assert capsys.readouterr().err == f"{NOTICE}\n"
    with told_of_compilation():
        assert [function(1) for function in functions] == [2, 3]
    assert njit(lambda x: x)(1) == 1  # outside of the context there is no notice
    assert capsys.readouterr() == ("", "")
