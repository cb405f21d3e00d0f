"""Functions that become part of their callers' machine code."""

from __future__ import annotations

import pytest
from numba import njit

from cbdsl.numeric.compiled import compiled


def _deep(x: float) -> float:
    return 3.0 * x


def _printing(x: float) -> float:
    print("value", x)  # noqa: T201 -- the printing function is under test
    return x


def _failing(x: float) -> float:
    if x < 0.0:
        raise ValueError("negative")
    return x


def test_inlined_function_has_no_machine_code_and_serves_its_callers() -> None:
    deep = compiled(_deep)

    def middle(x: float) -> float:
        return deep(x) + deep(2.0 * x)

    inner = compiled(middle)

    @njit
    def outer(x: float) -> float:
        return inner(x) + deep(x)

    assert outer(2.0) == 9.0 * 2.0 + 3.0 * 2.0
    for function in (deep, inner):
        (result,) = function.overloads.values()  # type: ignore[attr-defined]
        engine = result.library._codegen._engine
        assert not engine.is_symbol_defined(result.fndesc.mangled_name)


def test_inlined_function_with_python_objects_reaches_its_environment(
    capfd: pytest.CaptureFixture[str],
) -> None:
    printing = compiled(_printing)

    @njit
    def outer(x: float) -> float:
        return printing(x) + 1.0

    assert outer(1.5) == 2.5
    assert capfd.readouterr().out == "value 1.5\n"


def test_inlined_function_that_raises_ends_its_caller() -> None:
    failing = compiled(_failing)

    @njit
    def outer(x: float) -> float:
        return failing(x) + 1.0

    assert outer(1.0) == 2.0
    with pytest.raises(ValueError, match="negative"):
        outer(-1.0)
