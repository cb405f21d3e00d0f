"""Queries about omitted parts, compared with an exhaustive search."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from cbdsl.yaml_text.broken import Broken

STEPS = st.lists(st.sampled_from(["a", "b", 0]), min_size=1, max_size=3).map(tuple)


@given(st.lists(STEPS, max_size=4), STEPS)
def test_path_is_touched_from_above_and_from_below(
    paths: list[tuple[str | int, ...]], steps: tuple[str | int, ...]
) -> None:
    broken = Broken(paths)
    below = [path for path in paths if path[: len(steps)] == steps]
    above = [path for path in paths if steps[: len(path)] == path]
    assert broken.holds(*steps) == (steps in paths)
    assert broken.is_below(steps) == bool(below)
    assert broken.touches(steps) == bool(below or above)


@given(st.lists(STEPS, max_size=4))
def test_keys_are_those_of_entries(paths: list[tuple[str | int, ...]]) -> None:
    entries = {str(path[1]) for path in paths if len(path) == 2 and path[0] == "a"}
    assert set(Broken(paths).keys(["a"])) == entries
