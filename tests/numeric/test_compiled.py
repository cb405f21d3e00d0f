"""Compiling: with and without a place to keep the result."""

from __future__ import annotations

import pytest

from cbdsl.numeric import compiled


def twice(x: float) -> float:
    return 2 * x


def test_it_works_where_nothing_can_be_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    njit = compiled.njit

    def nowhere(*, cache: bool = False, **options: object) -> object:
        if cache:
            raise RuntimeError("no locator available")
        return njit(**options)

    monkeypatch.setattr(compiled, "njit", nowhere)
    assert compiled.compiled_once(twice)(2.5) == 5.0


def test_compiled_functions_are_those_of_the_source() -> None:
    assert compiled.compiled(twice)(2.5) == twice(2.5)
