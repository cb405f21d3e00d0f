"""Coordinate ascent over a grid of joint positions."""

from __future__ import annotations

from collections.abc import Callable, Sequence

# Smallest improvement that counts. Among equal scores the earlier choice stays.
_LEAST = 1e-9


def ascend(
    first: tuple[float, ...],
    choices: Sequence[Sequence[float]],
    score: Callable[[tuple[float, ...]], float],
    sweeps: int,
) -> tuple[tuple[float, ...], float]:
    """Return the best positions near the first ones, and their score.

    A sweep tries all choices of one joint after another. It needs n k evaluations instead of k^n,
    and may end in a local maximum. The result is the same in each run.

    Args:
        first: Position of each joint, rad or m.
        choices: Positions to try, by joint; none for a joint that keeps its position.
        score: Function of the positions to be maximized.
        sweeps: Largest number of sweeps; a sweep without improvement is the last.
    """
    best, highest = first, score(first)
    for _ in range(sweeps):
        before = highest
        for index, positions in enumerate(choices):
            for position in positions:
                tried = (*best[:index], position, *best[index + 1 :])
                its_score = score(tried)
                if its_score > highest + _LEAST:
                    best, highest = tried, its_score
        if highest <= before:
            break
    return best, highest
