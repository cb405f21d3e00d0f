"""Patches: single changes of programs and stages, tried on the seed of a failure and on others."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cbdsl import DiagnosticsError, UsageError, open_robot
from cbdsl.api.documents import ProgramDocument, StageDocument, require_unlinked, write_text
from cbdsl.api.shipped import shipped_folder
from cbdsl.extend.document import is_of
from cbdsl_why.given_values import GivenValues, ParameterScope
from cbdsl_why.structural_patches import (
    ALLOCATION,
    EXITS,
    Patch,
    PatchedText,
    changed_allocations,
    changed_exits,
)

if TYPE_CHECKING:
    from cbdsl import RunRequest
    from cbdsl.extend.command import RunOptions
    from cbdsl.extend.document import Node
    from cbdsl_why.diagnosis import Diagnosis
    from cbdsl_why.history import History

# Largest numbers of changes that are tried, on the seed of the failure and on fresh seeds.
_MOST, _CHOSEN = 30, 3
# Time before a cause in which a controller acted that may have to do with it, s.
_BEFORE = 0.5
# Fresh seeds are these numbers after the seed of the failure.
_FRESH = range(1001, 1006)
_TIMES = ("transitions", "transition_time", "idle_time", "episode_time", "lost_time")
_LOADS = ("finger_force", "hand_force", "joint_torque")
# Factors of a change, by key. Goals, tolerances and states of success never change.
_FACTORS = {
    **dict.fromkeys(("speed", "gain"), (0.5, 2.0, 10.0)),
    **dict.fromkeys(("acceleration", "pace", "least"), (0.5, 2.0)),
    "window": (2.0, 0.5, 0.1),
    **dict.fromkeys(_LOADS, (2.0, 0.5)),
    **dict.fromkeys(_TIMES, (2.0, 4.0)),
    "reference": (2.0, 5.0, 20.0, 0.5),
    "height": (2.0,),
    "clearance": (0.5,),
}
# Numbers of stages, whose change makes another world.
_OF_STAGES = {"mass": (0.5,), "friction": (2.0,)}
# Keys and families that are the likeliest ones by kind of cause, and their turns for one of others.
_TURNS = 4
_LIKELY = {
    "slip": ("reference", "acceleration", "speed"),
    "no_grasp": ("reference", "window", "speed"),
    "time": ("transition_time", "episode_time", "transitions", "speed"),
    "guard": (*_LOADS, "clearance"),
    "lost": ("lost_time", "speed"),
    **dict.fromkeys(("out_of_reach", "stuck", "limit"), (ALLOCATION,)),
    **dict.fromkeys(("stated", "cycle", "no_action", "wrong_order"), (EXITS, ALLOCATION)),
}
_NUMBER = re.compile(r"\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")


def patched(
    program: str, options: RunOptions, history: History, diagnosis: Diagnosis, *, apply: bool
) -> dict[str, Any]:
    """Try changes on the seed of a failure, with the same world and noise, and then on others.

    Args:
        program: Program that failed: file or name.
        options: Options of its run.
        history: History of the failed episode.
        diagnosis: Diagnosis of the episode.
        apply: True to write the best change to its document.

    Returns:
        Number of tried changes, and the best one; ``None`` if none raised the rate of success.

    Raises:
        UsageError: The document to be changed is shipped with the package.
        OSError: It cannot be written, or was found by a link that the user has not named.
    """
    request, seed = options.request(program), history.result["seed"]
    tried, before, helped = 0, -1, list[tuple[int, Patch]]()
    with open_robot(request, backend=options.backend, cameras=options.cameras) as robot:

        def count(changed: RunRequest, seeds: Iterable[int]) -> int:
            same = robot.with_program(changed)
            return sum(same.run(seed, context=options.context).succeeded for seed in seeds)

        fresh = [seed + later for later in _FRESH]
        kind = "" if diagnosis.cause is None else diagnosis.cause.kind
        last = history.last if diagnosis.cause is None else diagnosis.cause.tick
        actions, active = history.result["actions"], history.acting(last, _BEFORE)
        for patch in patches(request, kind, actions, options.values, active):
            try:
                changed = options.request(
                    program, {patch.file: patch.text.encode("utf-8", "backslashreplace")}
                )
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
    if apply:
        _write(best, request, {Path(program), Path(options.stage or program)})
    rates = {"before": before, "after": after, "seeds": len(fresh)}
    return {"tried": tried, "patch": {"edit": str(best), "applied": apply, **rates}}


def _write(patch: Patch, request: RunRequest, named: Collection[Path]) -> None:
    """Write a change to its document, unless only a link of a folder leads there."""
    if patch.file.is_relative_to(shipped_folder()):
        raise UsageError(f"{patch} would change a shipped document: copy it beside the program")
    links = request.library.links_to(patch.file)
    for link in links if links.isdisjoint(named) else ():
        require_unlinked(link)
    write_text(patch.text, patch.file)


def patches(
    request: RunRequest,
    kind: str,
    actions: Sequence[str] = (),
    given: Collection[str] = (),
    active: Collection[str] = (),
) -> list[Patch]:
    """Return changes that may help against a kind of cause, in the order of their trials.

    Args:
        request: Request of the failed run.
        kind: Kind of the first cause; empty for an unknown one.
        actions: Actions of the failed episode, in order; exits of the last ones come first.
        given: Parameters with values of the command line, whose defaults do not count.
        active: Controllers that acted when the cause began; their changes come first.
    """
    # An alias repeats a value, whose change is one.
    made = {(each.file, each.text): each for each in _changes(request, actions, given)}
    likely = _LIKELY.get(kind, ())
    # Families take turns, so that no family uses up all trials; the world changes last.
    counts, turns = Counter[str](), list[tuple[bool, float, int, Patch]]()
    for patch in sorted(made.values(), key=lambda each: not any(k in active for k in each.keys)):
        family = patch.family
        place = likely.index(family) if family in likely else len(likely)
        turn = counts[family] / (_TURNS if family in likely else 1)
        turns.append((family in _OF_STAGES, turn, place, patch))
        counts[family] += 1
    return [turn[-1] for turn in sorted(turns, key=lambda turn: turn[:-1])]


def _changes(
    request: RunRequest, actions: Sequence[str], given: Collection[str]
) -> Iterator[Patch]:
    """Yield the changes of programs and stages, and last of the called shared controllers."""
    library, values = request.library, GivenValues(request.library, _FACTORS)
    recent = [request.program.steps.get(action, action) for action in reversed(actions)]
    programs = [ParameterScope(file) for file in library.files if is_of(ProgramDocument, file)]
    for file in library.files:
        whole = PatchedText(file, library.text(file), values.source(file).root)
        if is_of(StageDocument, file):
            yield from _numbers(whole, whole.root, (), _OF_STAGES)
        elif ParameterScope(file) in programs:
            yield from _numbers(whole, whole.root, (), _FACTORS)
            yield from _given_numbers(whole, values, ParameterScope(file), given)
            yield from changed_exits(whole, recent)
            if library.real(file) == library.real(request.program_file):
                yield from changed_allocations(whole, request.robot, given)
    for scope in values.all_called(programs):
        whole = PatchedText(scope.file, library.text(scope.file), values.source(scope.file).root)
        yield from _numbers(whole, values.node(scope), values.keys(scope), _FACTORS)
        yield from _given_numbers(whole, values, scope)


def _numbers(
    whole: PatchedText,
    node: Node,
    keys: tuple[str | int, ...],
    factors: Mapping[str, Sequence[float]],
) -> Iterator[Patch]:
    """Yield the changes of the numbers of a value of a document, but not of given values."""
    for step, child in node.steps():
        if step not in ("parameters", "with"):
            yield from _numbers(whole, child, (*keys, step), factors)
    place, key = node.place, str(keys[-1]) if keys else ""
    if isinstance(node.value, dict | list) or key not in factors or not place.end_column:
        return
    written = whole.written(place)
    # A force along normals is no goal of a motion, unlike a place.
    if key == "reference" and " along " not in written:
        return
    for after in _multiples(written, factors[key]):
        yield whole.patch(key, keys, [(place, after)])


def _given_numbers(
    whole: PatchedText, values: GivenValues, scope: ParameterScope, given: Collection[str] = ()
) -> Iterator[Patch]:
    """Yield the changes of numbers that a text gives to others, and to its own parameters."""
    for each in (*values.given(scope), *values.defaults(scope)):
        is_given = each.scope == scope and each.parameter in given
        key = "" if is_given else values.meaning(each.scope, each.parameter)
        # A text with escapes has no places of its parts.
        if whole.written(each.place).strip("\"'") == each.value:
            for other in _multiples(each.value, _FACTORS.get(key, ())):
                yield whole.patch(key, each.path, [(each.place, other)])


def _multiples(written: str, factors: Iterable[float]) -> Iterator[str]:
    """Yield the multiples of a number with its unit, as written."""
    number = _NUMBER.match(written)
    if number is not None:
        for factor in factors:
            yield f"{float(number[0]) * factor:.4g}{written[number.end() :]}"
