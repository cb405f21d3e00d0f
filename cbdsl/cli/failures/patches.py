"""Patches of programs: single changes of numbers, tried on the seed of a failure and on others."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from cbdsl.api.open_robot import open_robot
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.diagnostics.legible_text import encoded
from cbdsl.documents.program import ProgramDocument
from cbdsl.yaml_text.composer import compose
from cbdsl.yaml_text.library import is_of

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.yaml_text.node import Node

# Largest numbers of changes that are tried, on the seed of the failure and on fresh seeds.
_MOST, _CHOSEN = 30, 3
# Fresh seeds are these numbers after the seed of the failure.
_FRESH = range(1001, 1006)
# Factors of a change, by key. Goals, tolerances and states of success never change.
_FACTORS = {
    "speed": (0.5, 2.0),
    "acceleration": (0.5, 2.0),
    "gain": (0.5, 2.0),
    "window": (2.0, 0.5),
    "reference": (2.0, 5.0, 0.5),
    "transitions": (2.0, 4.0),
    "transition_time": (2.0, 4.0),
    "idle_time": (2.0, 4.0),
    "episode_time": (2.0, 4.0),
    "lost_time": (2.0, 4.0),
    "finger_force": (2.0, 0.5),
    "hand_force": (2.0, 0.5),
    "joint_torque": (2.0, 0.5),
    "pace": (0.5, 2.0),
    "height": (2.0,),
    "least": (0.5, 2.0),
    "clearance": (0.5,),
}
# Keys that are tried first, by kind of cause.
_FIRST = {
    "slip": ("reference", "acceleration", "speed"),
    "no_grasp": ("reference", "window", "speed"),
    "time": ("transition_time", "episode_time", "transitions", "speed"),
    "guard": ("finger_force", "hand_force", "joint_torque", "clearance"),
    "lost": ("lost_time", "speed"),
}
_NUMBER = re.compile(r"\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")

Read = Callable[[Mapping[Path, bytes]], "RunRequest"]


class Patch(NamedTuple):
    """Change of one number of a document: file, line, path of keys, and value before and after."""

    file: Path
    line: int
    keys: tuple[str | int, ...]
    before: str
    after: str
    text: str

    def __str__(self) -> str:
        keys = ".".join(map(str, self.keys))
        return f"{self.file}:{self.line} {keys}: {self.before} -> {self.after}"


class TriedPatch(NamedTuple):
    """Patch that succeeded where the program failed, and successes on fresh seeds.

    Attributes:
        patch: Change.
        before: Number of successes without it.
        after: Number of successes with it.
        seeds: Number of fresh seeds.
    """

    patch: Patch
    before: int
    after: int
    seeds: int = len(_FRESH)


def patches(request: RunRequest, kind: str) -> list[Patch]:
    """Return the changes that may help against a kind of cause, the likeliest first."""
    made = [
        patch
        for file in request.library.files
        if is_of(ProgramDocument, file)
        for patch in _of_document(file, request.library.text(file))
    ]
    first = _FIRST.get(kind, ())
    return sorted(
        made, key=lambda p: first.index(p.keys[-1]) if p.keys[-1] in first else len(first)
    )


def try_patches(
    request: RunRequest,
    read: Read,
    seed: int,
    kind: str,
    backend: str,
    cameras: str | None,
    context: str | None,
) -> tuple[int, TriedPatch | None]:
    """Try changes on the seed of a failure, with the same world and noise, and then on others.

    Args:
        request: Program that failed.
        read: Function that reads it with other contents of files.
        seed: Seed of the failure.
        kind: Kind of its cause.
        backend: Name of the backend.
        cameras: Kind of cameras.
        context: Context of the stage.

    Returns:
        Number of tried changes, and the best one; ``None`` if none raised the rate of success.
    """
    tried, helped = 0, list[TriedPatch]()
    with open_robot(request, backend=backend, cameras=cameras) as robot:

        def count(program: RunRequest, seeds: range | list[int]) -> int:
            own = robot.with_program(program)
            return sum(own.run(each, context=context).succeeded for each in seeds)

        fresh, before = [seed + each for each in _FRESH], -1
        for patch in patches(request, kind):
            try:
                changed = read({patch.file: encoded(patch.text)})
            except (DiagnosticsError, UsageError):
                continue  # a value that does not check is no patch
            tried += 1
            if count(changed, [seed]):
                before = count(request, fresh) if before < 0 else before
                helped.append(TriedPatch(patch, before, count(changed, fresh)))
            if tried == _MOST or len(helped) == _CHOSEN:
                break
    best = max(helped, key=lambda each: each.after, default=None)
    return tried, best if best is not None and best.after > best.before else None


def _of_document(file: Path, text: str) -> Iterator[Patch]:
    """Yield the changes of a document's numbers."""
    lines = text.splitlines(keepends=True)
    for keys, node in _leaves(compose(text, str(file)).root):
        place, last = node.place, keys[-1] if keys else ""
        line = lines[place.line - 1]
        written = line[place.column - 1 : place.end_column - 1] if place.end_column else ""
        number = _NUMBER.match(written)
        # A force along normals is no goal of a motion, unlike a place.
        is_goal = last == "reference" and " along " not in written
        if number is None or is_goal:
            continue
        for factor in _FACTORS.get(str(last), ()):
            after = f"{float(number[0]) * factor:.4g}{written[number.end() :]}"
            begin, end = line[: place.column - 1], line[place.column - 1 + len(written) :]
            changed = [*lines[: place.line - 1], begin + after + end, *lines[place.line :]]
            yield Patch(file, place.line, keys, written, after, "".join(changed))


def _leaves(
    node: Node, keys: tuple[str | int, ...] = ()
) -> Iterator[tuple[tuple[str | int, ...], Node]]:
    """Yield the scalars of a document with their keys."""
    if not isinstance(node.value, dict | list):
        yield keys, node
    for step, child in node.steps():
        yield from _leaves(child, (*keys, step))
