"""Patches of programs: single changes of numbers, tried on the seed of a failure and on others."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from cbdsl.api.open_robot import open_robot
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.diagnostics.legible_text import encoded
from cbdsl.diagnostics.lines import lines_of
from cbdsl.documents.program import ProgramDocument
from cbdsl.editor.fixes import Fix, replaced
from cbdsl.storage.atomic_file import write_text
from cbdsl.yaml_text.composer import compose
from cbdsl.yaml_text.library import is_of, shipped

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.cli.run import RunOptions
    from cbdsl.yaml_text.node import Node

# Largest numbers of changes that are tried, on the seed of the failure and on fresh seeds.
_MOST, _CHOSEN = 30, 3
# Fresh seeds are these numbers after the seed of the failure.
_FRESH = range(1001, 1006)
_TIMES = ("transitions", "transition_time", "idle_time", "episode_time", "lost_time")
_LOADS = ("finger_force", "hand_force", "joint_torque")
# Factors of a change, by key. Goals, tolerances and states of success never change.
_FACTORS = {
    **dict.fromkeys(("speed", "acceleration", "gain", "pace", "least"), (0.5, 2.0)),
    **dict.fromkeys(("window", *_LOADS), (2.0, 0.5)),
    **dict.fromkeys(_TIMES, (2.0, 4.0)),
    "reference": (2.0, 5.0, 0.5),
    "height": (2.0,),
    "clearance": (0.5,),
}
# Keys that are tried first, by kind of cause.
_FIRST = {
    "slip": ("reference", "acceleration", "speed"),
    "no_grasp": ("reference", "window", "speed"),
    "time": ("transition_time", "episode_time", "transitions", "speed"),
    "guard": (*_LOADS, "clearance"),
    "lost": ("lost_time", "speed"),
}
_NUMBER = re.compile(r"\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")


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


def patched(
    program: str, options: RunOptions, row: Mapping[str, Any], *, apply: bool
) -> dict[str, Any]:
    """Try changes on the seed of a failure, with the same world and noise, and then on others.

    Args:
        program: Program that failed: file or name.
        options: Options of its run.
        row: Diagnosis of the failure.
        apply: True to write the best change to its document.

    Returns:
        Number of tried changes, and the best one; ``None`` if none raised the rate of success.

    Raises:
        UsageError: The document to be changed is shipped with the package.
    """
    request, seed = options.request(program), row["seed"]
    tried, before, helped = 0, -1, list[tuple[int, Patch]]()
    with open_robot(request, backend=options.backend, cameras=options.cameras) as robot:

        def count(changed: RunRequest, seeds: Iterable[int]) -> int:
            same = robot.with_program(changed)
            return sum(same.run(seed, context=options.context).succeeded for seed in seeds)

        fresh = [seed + later for later in _FRESH]
        for patch in patches(request, "" if row["cause"] is None else row["cause"]["kind"]):
            try:
                changed = options.request(program, {patch.file: encoded(patch.text)})
            except (DiagnosticsError, UsageError):
                continue  # a value that does not check is no patch
            tried += 1
            if count(changed, [seed]):
                before = count(request, fresh) if before < 0 else before
                helped.append((count(changed, fresh), patch))
            is_best = bool(helped) and helped[-1][0] == len(fresh)
            if is_best or tried == _MOST or len(helped) == _CHOSEN:
                break
    after, best = max(helped, key=lambda each: each[0], default=(before, None))
    if best is None or after <= before:
        return {"tried": tried, "patch": None}
    if apply and best.file.is_relative_to(shipped()):
        raise UsageError(f"{best} would change a shipped document: copy it beside the program")
    if apply:
        write_text(best.text, best.file, follow=True)
    rates = {"before": before, "after": after, "seeds": len(fresh)}
    return {"tried": tried, "patch": {"edit": str(best), "applied": apply, **rates}}


def patches(request: RunRequest, kind: str) -> list[Patch]:
    """Return the changes that may help against a kind of cause, the likeliest first."""
    library, made = request.library, list[Patch]()
    for file in library.files:
        if is_of(ProgramDocument, file):
            text = library.text(file)
            made += _of_node(file, text, compose(text, str(file)).root, ())
    order: dict[str | int, int] = {key: place for place, key in enumerate(_FIRST.get(kind, ()))}
    return sorted(made, key=lambda each: order.get(each.keys[-1], len(order)))


def _of_node(file: Path, text: str, node: Node, keys: tuple[str | int, ...]) -> Iterator[Patch]:
    """Yield the changes of the numbers of a value of a document."""
    for step, child in node.steps():
        yield from _of_node(file, text, child, (*keys, step))
    place, key = node.place, str(keys[-1]) if keys else ""
    if isinstance(node.value, dict | list) or key not in _FACTORS or not place.end_column:
        return
    written = lines_of(text)[place.line - 1][place.column - 1 : place.end_column - 1]
    number = _NUMBER.match(written)
    # A force along normals is no goal of a motion, unlike a place.
    if number is None or (key == "reference" and " along " not in written):
        return
    for factor in _FACTORS[key]:
        after = f"{float(number[0]) * factor:.4g}{written[number.end() :]}"
        changed = replaced(text, [Fix(place.line, place.column, place.end_column, after)])
        yield Patch(file, place.line, keys, written, after, changed)
