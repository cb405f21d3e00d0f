"""Force error of a hand that slides over a table, by the truth of the fingertips' forces."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from cbdsl import EpisodeResult, load, simulate
from cbdsl.api.control import Floats
from cbdsl.api.sensing import Tick
from cbdsl_reproduction.judges.judge import Aim, BodyChoice, EpisodeVerdict, Judge, JudgedCondition

# Reference of the force and its tolerance, N; distance to slide and its tolerance, m.
_FORCE, _TOLERANCE, _WAY, _CLOSE = 3.0, 0.5, 0.10, 0.005
# Time over which the force is averaged, s.
_WINDOW = 0.1


class _Slide:
    """Forces and places of a slide, in every physics step instead of every control tick.

    Fingertips that rub lose contact for single steps, which ticks alone count as too many or
    too few.

    Args:
        engine: Engine of the simulated world.
        arm: Link at the tip of the arm.
        hand: Name of the hand.
    """

    def __init__(self, engine: Any, arm: str, hand: str) -> None:
        self._engine, self._arm = engine, arm
        self._cells = [place for place, (owner, _) in enumerate(engine.cells) if owner == hand]
        self._step, engine.step = engine.step, self._sample
        self._sliding = False
        self.forces: list[float] = []
        self.places: list[Floats] = []

    def _sample(self, targets: Floats) -> None:
        self._step(targets)
        if self._sliding:
            # The reference is the force of the whole hand, which its fingertips may share unevenly.
            self.forces.append(-float(self._engine.wrenches()[self._cells, 2].sum()))

    def note(self, tick: Tick) -> None:
        """Take in a control tick."""
        action = tick.run.action
        self._sliding = action is not None and action.name.startswith("along")
        if self._sliding:
            self.places.append(self._engine.link_pose(self._arm).position.copy())

    def verdict(self, result: EpisodeResult, by: Floats, window: int) -> EpisodeVerdict:
        """Return the verdict on a slide by a displacement, m, shape (2,).

        Args:
            result: Result of the episode.
            by: Desired displacement, m, shape (2,).
            window: Number of physics steps over which the force is averaged.
        """
        strayed = missed = math.nan
        if len(self.forces) >= window:
            means = np.convolve(self.forces, np.full(window, 1 / window), mode="valid")
            # The worst window counts, so that a loss of
            # contact does not average out over the slide.
            strayed = float(np.abs(means - _FORCE).max())
            missed = float(np.linalg.norm((self.places[-1] - self.places[0])[:2] - by))
        is_good = result.outcome == "success" and strayed <= _TOLERANCE and missed <= _CLOSE
        return EpisodeVerdict(
            result.seed,
            {"within tolerance": is_good},
            result.sim_seconds,
            result.ending,
            {"force_error_n": strayed, "missed_mm": 1e3 * missed},
        )


def drawn_slide(seed: int, side: str) -> tuple[dict[str, str], Floats]:
    """Return the parameters of a slide from a random place in a random direction.

    Args:
        seed: Seed of the draw.
        side: ``left`` or ``right``.

    Returns:
        Values of the program's parameters, and the displacement, m, shape (2,).
    """
    rng = np.random.default_rng([seed, 7])
    x, y, angle = rng.uniform(0.40, 0.55), rng.uniform(-0.35, -0.15), rng.uniform(0, 2 * np.pi)
    by = _WAY * np.array([np.cos(angle), np.sin(angle)])
    lengths = {"x": x, "y": y if side == "right" else -y, "by_x": by[0], "by_y": by[1]}
    values = {name: f"{value:.5f} m" for name, value in lengths.items()}
    return {**values, "arm": f"{side}_arm", "hand": f"{side}_hand"}, by


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each slide, which has a world of its own."""
    for seed in seeds:
        values, by = drawn_slide(seed, condition.name.split()[0])
        request = load(condition.program, values=values)
        tip = request.robot.effectors[values["arm"]].tip
        assert tip is not None, "arms of the shipped robot have tips"
        with simulate(request, backend=body.backend, cameras=body.cameras) as simulated:
            engine = getattr(simulated.robot.backend, "truth")  # noqa: B009 (simulated ones only)
            slide = _Slide(engine, tip.link, values["hand"])
            result = simulated.robot.run(seed, on_tick=slide.note)
            window = round(_WINDOW * request.robot.simulation.physics_rate)
            yield slide.verdict(result, by, window)


JUDGE = Judge(
    "force",
    "slides over a table at 3 N, within 0.5 N and 5 mm",
    tuple(
        JudgedCondition(
            f"{side} hand",
            "press_and_slide",
            {"within tolerance": Aim(0.95)},
            values={"arm": f"{side}_arm", "hand": f"{side}_hand"},
        )
        for side in ("right", "left")
    ),
    _measure,
    # The program uses no vision.
    BodyChoice("bullet", "ideal"),
    episodes=40,
)
