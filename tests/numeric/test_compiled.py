"""Compiling: code kept for the next process, its lifetime, and calls by address."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import njit, types
from numba.experimental import function_type

from cbdsl.control.potential import address_of, call_at, potential
from cbdsl.numeric import compiled
from cbdsl.numeric.arrays import Floats

INNER = """
from cbdsl.numeric.compiled import compiled

@compiled
def grown(x: float) -> float:
    return x + {}
"""
OUTER = """
from cbdsl.numeric.compiled import compiled_once
from kernels.inner import grown

@compiled_once
def doubled(x: float) -> float:
    return 2.0 * grown(x)
"""
CALL = """
from kernels.outer import doubled
print(doubled(3.0), sum(doubled.stats.cache_hits.values()))
"""


def twice(x: float) -> float:
    return 2 * x


def test_compiled_functions_are_those_of_the_source() -> None:
    @njit
    def call(x: float) -> float:
        return own(x)

    own = compiled.compiled(twice)
    assert call(2.5) == twice(2.5)


def test_edit_of_a_callee_in_another_file_is_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Unedited code is not compiled again."""
    package = tmp_path / "kernels"
    package.mkdir()
    (package / "__init__.py").write_text("", encoding="utf-8")
    (package / "outer.py").write_text(OUTER, encoding="utf-8")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    found = []
    for added in (1.0, 1.0, 2.0, 2.0, 1.0):
        (package / "inner.py").write_text(INNER.format(added), encoding="utf-8")
        found.append(run(tmp_path))
    assert found == ["8.0 0", "8.0 1", "10.0 0", "10.0 1", "8.0 1"]


def run(folder: Path) -> str:
    code = f"import sys; sys.path.insert(0, {str(folder)!r}){CALL}"
    # Without bytecode: Python detects an edited file only by whole seconds and by its size.
    words = [sys.executable, "-B", "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_function_is_called_by_its_address() -> None:
    """Check the one feature of numba that is used but not guaranteed by its documentation."""
    assert callable(function_type._get_jit_address)

    @potential
    def product(
        value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
    ) -> float:
        residual[0] = value[0] - reference[1]
        slope[0, 1] = parameters[0]
        return 3.0 * value[1]

    @njit(types.float64(types.int64, *[types.float64[::1]] * 4, types.float64[:, ::1]))
    def call(
        address: int, value: Floats, there: Floats, own: Floats, residual: Floats, slope: Floats
    ) -> float:
        return call_at(address, value, there, own, residual, slope)

    residual, slope = np.zeros(1), np.zeros((1, 2))
    arguments = np.array([1.0, 2.0]), np.array([3.0, 4.0]), np.array([5.0]), residual, slope
    assert call(address_of(product), *arguments) == 6.0
    assert residual.tolist() == [-3.0]
    assert slope.tolist() == [[0.0, 5.0]]


def test_literal_argument_adds_no_second_compilation() -> None:
    @compiled.compiled
    def grown(count: int) -> int:
        return count + 1

    @njit
    def repeat(times: int) -> int:
        count = 0
        for _ in range(times):
            count = grown(count)
        return count

    assert repeat(3) == 3
    assert len(grown.signatures) == 1  # type: ignore[attr-defined]
