"""Content of one tick on a live page."""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.staging.world_state import WorldState
from cbdsl.program.condition import ProgramCondition
from cbdsl.reporting.thumbnails import encoded
from cbdsl.runtime.explanation import Explanation, TickExplanation, named_runs
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.runtime.tick import Tick
from cbdsl.types.resource import Resource

# Half of the images' width suffices for display.
_SCALE = 0.5


def frame(
    tick: Tick, places: Sequence[Resource], world: WorldState | None, names: Sequence[str]
) -> dict[str, Any]:
    """Return a tick in JSON types; undefined numbers are null.

    Args:
        tick: State of the episode.
        places: Resources with points in the world as values.
        world: True state of the world, for display only.
        names: Names of the controllers, including those of used programs.
    """
    observation, run = tick.observation, tick.run
    runs = [each for _, each in named_runs(run)]
    explained = Explanation().note(tick)
    return {
        "time": round(observation.time, 6),
        "positions": _numbers(observation.positions),
        "bodies": {} if world is None else {name: _pose(world, name) for name in world.names()},
        "state": run.state,
        "action": "" if run.action is None else run.action.name,
        "running": list(_running(run, tick)),
        "predicates": "".join(each.predicate for each in runs),
        "potentials": [_number(each.phi) for each in runs],
        "errors": [_number(each.error) for each in runs],
        "levels": _levels(explained, names),
        "points": {each.name: _point(each, tick) for each in places},
        "forces": [_number(float(np.linalg.norm(w[:3]))) for w in tick.signals.touch.loads],
        "limits": list(explained.at_limits),
        "guards": list(explained.guards),
    }


def _running(run: ProgramRun, tick: Tick, use: str = "") -> Iterator[dict[str, object]]:
    """Yield the running program and the running programs that it uses, with members' values.

    A controller's value is its distance from its target, and a condition's are its signals.
    """
    action, program = run.action, run.program
    if action is None:
        return
    values = {name: _compared(program.conditions[name], tick) for name in action.conditions}
    parts = action.composition.primitives if action.composition else ()
    for part, lead in zip(parts, reversed(run.leads(action)), strict=True):
        known = math.isfinite(lead.error)
        values[part.name] = f"{lead.error:.3g} {lead.controller.task.unit}" if known else ""
    yield {
        "program": program.name,
        "use": use,
        "action": action.name,
        "state": run.state,
        "stuck": run.stuck,
        "values": values,
    }
    child = run.children.get(action.name)
    if child is not None and child.predicate == "0":
        yield from _running(child, tick, f"{use}.{action.name}" if use else action.name)


def _compared(condition: ProgramCondition, tick: Tick) -> str:
    """Return the signals that a condition compares, in SI."""
    texts = []
    for component in (each for sum_ in condition.comparisons for each in sum_.factors):
        reading = tick.signals.read(component.resource)
        shown = "–" if reading is None else f"{reading.value[component.axis]:.3g}"  # noqa: RUF001
        pair = tick.signals.distances.pair(component.resource)
        texts.append(f"{component.resource.name} {shown}{pair and f' ({pair})'}")
    return ", ".join(dict.fromkeys(texts))


def _levels(explained: TickExplanation, names: Sequence[str]) -> list[dict[str, object]]:
    """Return active levels, highest priority first, each with the index of its controller."""
    return [
        {
            "controller": names.index(level.name),
            "share": _number(level.share),
            "rank": level.rank,
            "singular_value": _number(level.singular_value),
            "held_by": level.held_by,
        }
        for level in explained.levels
    ]


def _pose(world: WorldState, name: str) -> list[float | None]:
    """Return position, m, and quaternion (x, y, z, w)."""
    pose = world.pose(name)
    return _numbers([*pose.position.tolist(), *pose.quaternion()])


def _point(resource: Resource, tick: Tick) -> list[float | None] | None:
    """Return a sensed point in the world frame, m, or ``None`` while it is not sensed."""
    reading = tick.signals.read(resource)
    return None if reading is None else _numbers(reading.value)


def _numbers(values: Sequence[float] | NDArray[np.float64]) -> list[float | None]:
    return [_number(float(value)) for value in values]


def _number(value: float) -> float | None:
    """Return a number with the precision of a page; JSON has neither NaN nor infinity."""
    return float(f"{value:.6g}") if math.isfinite(value) else None


def images(tick: Tick) -> Callable[[], dict[str, str]]:
    """Return a function that packs the camera images of a tick later.

    It returns WebP images, encoded as Base64, by camera.
    """
    # The copy is made now; encoding, which takes longer, is left to the thread of a page.
    small = {
        camera: cv2.resize(image, None, fx=_SCALE, fy=_SCALE)
        for camera, image in tick.observation.images.items()
    }

    def pack() -> dict[str, str]:
        return {
            camera: b64encode(encoded(np.asarray(image)[None])[0]).decode()
            for camera, image in small.items()
        }

    return pack
