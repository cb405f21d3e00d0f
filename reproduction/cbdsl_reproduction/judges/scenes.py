"""Errors of the memory of several objects: separated, out of view, removed, and held.

Three balls lie on a table, two of them of one hue. In every image the robot's memory is compared
with the truth:

- ``in view``: both cameras see all of each ball. A position is right within 1 cm; one outside of
  every ball of its hue is a ghost.
- ``anywhere``: some balls are out of view, cut off by an image's border, or occluded. Only ghosts
  count, since such balls may be unknown.
- ``remembered``: the head looks away for 10 s, so that no ball is in view, and back.
- ``removed``: one of the two balls is removed meanwhile. It has to be forgotten within 1 s after
  both cameras show its place, and nothing else may be.
- ``carried``: a hand takes one of two balls that both cameras see, and holds it above the other, of
  the same hue or not. The other ball and its remembered position must not move. Scenes in which the
  carry fails, such as those in which the hand pushes the other ball, do not count.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from cbdsl.api.control import Floats
from cbdsl.api.sensing import EpisodeListeners, Runner, Tick
from cbdsl_reproduction.judges.balls import (
    AWAY,
    CARRYING,
    COLORS,
    RUN,
    TABLE,
    Rig,
    drawn,
    drawn_for_carrying,
    drawn_in_view,
    exhaust,
    stage_of,
)
from cbdsl_reproduction.judges.judge import (
    NONE,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)

# Outcome of each ball of a scene, or of the scene: right, wrong, or not counted.
Outcomes = Sequence[bool | None]


def in_view(rig: Rig, rng: np.random.Generator) -> Outcomes:
    """Look at whole balls."""
    balls, joints = drawn_in_view(rig, rng)
    rig.show(balls, rng, **joints)
    exhaust(rig.look(1.0))
    return [number is not None for number in rig.numbers()]


def anywhere(rig: Rig, rng: np.random.Generator) -> Outcomes:
    """Look from one end to the other."""
    rig.show(drawn(rng, wide=True), rng, pan=rng.uniform(-0.5, 0.5), tilt=rng.uniform(0.8, 1.3))
    for pan in rng.uniform(-0.5, 0.5, 4):
        exhaust(rig.look(0.5, pan=pan))
    return [not rig.ghosts]


def remembered(rig: Rig, rng: np.random.Generator) -> Outcomes:
    """Look away for 10 s, and back."""
    balls, joints = drawn_in_view(rig, rng)
    rig.show(balls, rng, **joints)
    exhaust(rig.look(1.0))
    before, kept = rig.numbers(), True
    for _ in rig.look(10.0, **AWAY):
        kept = kept and rig.numbers() == before
    exhaust(rig.look(3.0, **joints))
    return [kept and None not in before and rig.numbers() == before]


def removed(rig: Rig, rng: np.random.Generator) -> Outcomes:
    """Look away while a ball is removed, and back."""
    balls, joints = drawn_in_view(rig, rng)
    rig.show(balls, rng, **joints)
    exhaust(rig.look(1.0))
    exhaust(rig.look(3.0, **AWAY))
    number = int(rng.integers(2))
    gone, rest = balls[number], [ball for k, ball in enumerate(balls) if k != number]
    rig.backend.truth.remove(f"ball_{number}")
    since, forgotten = math.inf, math.inf
    for time in rig.look(5.0, **joints):
        since = min(since, time if rig.shows(gone) else math.inf)
        place = rig.place(gone)
        if place is None or place[1] > gone.radius:
            forgotten = min(forgotten, time)
    rig.balls = rest
    # A ball that is forgotten before its place is in view was lost for another reason.
    in_time = math.isfinite(since) and since <= forgotten <= since + 1.0
    return [in_time and None not in rig.numbers()]


def carried(rig: Rig, runner: Runner, channel: str, rng: np.random.Generator) -> Outcomes:
    """Carry a ball above another; not counted if nothing was carried there or ran away."""
    balls = drawn_for_carrying(rig, channel, rng)
    things = {
        name: {
            "form": {"shape": "ball", "radius": ball.radius},
            "mass": 0.2,
            "color": COLORS[ball.channel],
        }
        for name, ball in balls.items()
    }
    placed = {
        name: {"things": [name], "place": {"on": "table"} | _level(ball.centre)}
        for name, ball in balls.items()
    }
    stage = stage_of(
        fixtures={"table": TABLE},
        things=things,
        contexts={"both": {"placed": placed, "joints": CARRYING}},
    )
    watch = _GoalWatch(rig, channel)
    runner.run(stage, int(rng.integers(2**31)), observer=EpisodeListeners(on_tick=watch))
    return [not watch.ran if watch.carried or watch.ran else None]


def _level(centre: Floats) -> dict[str, list[float]]:
    x, y, _ = centre.tolist()
    return {"x": [x, x], "y": [y, y]}


class _GoalWatch:
    """Comparison of the memory of a fixed goal with its true place, tick by tick.

    Attributes:
        carried: True if a ball was carried to above the goal.
        ran: True if the goal's remembered place has left the goal.
    """

    def __init__(self, rig: Rig, channel: str) -> None:
        self._rig, self._channel = rig, channel
        self._starts: Mapping[str, Floats] = {}
        self.carried = self.ran = False

    def __call__(self, tick: Tick) -> None:
        truth = self._rig.backend.truth
        places = {name: truth.pose(name).position.copy() for name in ("taken", "goal")}
        self._starts = self._starts or places
        shifts = {name: math.dist(places[name], self._starts[name]) for name in places}
        # With two balls of one hue, the hand may take either; the goal is the ball that stays.
        moved, goal = sorted(places, key=lambda name: -shifts[name])
        if shifts[goal] > 0.01 or shifts[moved] < 0.1:
            return
        self.carried = self.carried or places[moved][2] > places[goal][2] + 0.1
        memories = tick.signals.vision.instances["red" if goal == "taken" else self._channel]
        known = [m.position for m in memories.memories if m.position is not None]
        errors = [math.dist(position, places[goal]) for position in known]
        held = [math.dist(position, places[moved]) for position in known]
        # A memory that is neither at the goal nor at the other ball has left one of them.
        strays = [min(e, h) for e, h in zip(errors, held, strict=True)]
        if errors:
            self.ran = self.ran or min(errors) > RUN or max(strays) > 2 * RUN


Scene = Callable[[Rig, np.random.Generator], Outcomes]

# Scenes by name, with the least share of right outcomes.
_SCENES: Mapping[str, tuple[Scene, float]] = {
    "in view": (in_view, 0.98),
    "anywhere": (anywhere, 1.0),
    "remembered": (remembered, 0.95),
    "removed": (removed, 1.0),
}
# Channel of the goal by name of the scene, and the goal of the program.
_CARRIED = {"carried, same hue": ("red", "red.2"), "carried, other hue": ("blue", "blue")}


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each ball of each scene."""
    rig, name = Rig(body.backend, body.cameras), condition.name
    with TemporaryDirectory() as folder:
        if name in _SCENES:
            show: Scene = _SCENES[name][0]
        else:
            channel, goal = _CARRIED[name]
            runner = rig.runner(goal, Path(folder))

            def show(rig: Rig, rng: np.random.Generator) -> Outcomes:
                return carried(rig, runner, channel, rng)

        for seed in seeds:
            for place, right in enumerate(show(rig, np.random.default_rng(seed))):
                # A scene with a ghost counts once, beside any of its balls.
                ghost = None if place else rig.ghosts > 0
                outcomes = {"right": right, "ghost": ghost}
                yield EpisodeVerdict(seed, outcomes, math.nan, "", context=f"ball {place}")
    rig.close()


JUDGE = Judge(
    "scenes",
    "memory of several objects, two of one hue",
    tuple(
        JudgedCondition(name, "", {"right": Aim(share), "ghost": NONE})
        for name, share in (
            *((name, own) for name, (_, own) in _SCENES.items()),
            *((name, 1.0) for name in _CARRIED),
        )
    ),
    _measure,
    BodyChoice("kinematic", "ideal"),
    episodes=200,
)
