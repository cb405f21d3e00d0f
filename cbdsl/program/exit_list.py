"""Short lists of exits: the same targets for all values of a step's members, in few words."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from functools import cache

from cbdsl.language.exit import WORDS
from cbdsl.program.automaton import Box, Exit, ProgramStep, To
from cbdsl.types.state import LETTERS

# Values of members up to which exits are searched. Beyond, the given boxes are kept.
_MOST_VALUES = 3**6


def with_short_exits(step: ProgramStep) -> ProgramStep:
    """Return a step that decides all values of its members in the same way, and goes on at rest.

    Args:
        step: Step with any target if no exit holds.
    """
    go_on = To(step.name)
    if math.prod(map(len, step.values)) > _MOST_VALUES:
        rest = Exit((step.values,), step.rest)
        exits = list(itertools.takewhile(lambda e: e.boxes != rest.boxes, step.exits))
        last = next((e for e in step.exits if e.boxes == rest.boxes), rest)
        exits += [] if last.to == go_on else [last]
        while exits and exits[-1].to == go_on:
            exits.pop()
    else:
        exits = _merged(_decision_list(step, go_on), step.values)
    return step._replace(exits=tuple(exits), rest=go_on)


# A decision list: each exit is the shortest box that holds, among the values that are left,
# values of one target only. Sets of values are integers with one bit each.
def _decision_list(step: ProgramStep, go_on: To) -> Iterator[Exit]:
    values = list(itertools.product(*step.values))
    bits = {value: 1 << i for i, value in enumerate(values)}
    targets: dict[To, int] = {}
    for value in values:
        to = step.decide(value)
        targets[to] = targets.get(to, 0) | bits[value]
    left = (1 << len(values)) - 1
    boxes = _boxes(step, bits)
    while left & ~targets.get(go_on, 0):
        box, mask, to = min(
            (
                (box, mask, to)
                for box, mask in boxes
                for to, own in targets.items()
                if to != go_on and mask & left and not mask & left & ~own
            ),
            key=lambda each: (
                _length(each[0], step.values),
                -(each[1] & left).bit_count(),
                not each[2].end,
            ),
        )
        if to.end == "success":
            box = _with_rest(box, [value for value in values if bits[value] & mask & left])
        left &= ~mask
        yield Exit((box,), to)


def _with_rest(box: Box, values: list[tuple[str, ...]]) -> Box:
    """Return a box of success that names each member that has to be at rest.

    A success is a failure if such a member rests beyond its tolerance.
    """
    rests = [{value[place] for value in values} == {"1"} for place in range(len(box))]
    return tuple("1" if at_rest else own for at_rest, own in zip(rests, box, strict=True))


def _merged(exits: Iterable[Exit], values: Box) -> list[Exit]:
    """Return exits of which successive ones with one target are joined if one box covers both."""
    merged: list[Exit] = []
    for exit_ in exits:
        box = (
            merged
            and merged[-1].to == exit_.to
            and _joined(merged[-1].boxes[0], exit_.boxes[0], values)
        )
        if box:
            merged[-1] = Exit((box,), exit_.to)
        else:
            merged.append(exit_)
    return merged


def _joined(one: Box, other: Box, values: Box) -> Box | None:
    """Return the union of two boxes that differ in the letters of one of several members."""
    different = [i for i, (a, b) in enumerate(zip(one, other, strict=True)) if a != b]
    if len(one) == 1 or len(different) != 1:
        return None
    place = different[0]
    both = "".join(x for x in LETTERS if x in one[place] + other[place])
    if both not in _lengths(values[place]):
        return None
    return (*one[:place], both, *one[place + 1 :])


def _boxes(step: ProgramStep, bits: dict[tuple[str, ...], int]) -> list[tuple[Box, int]]:
    """Return the boxes that have words, with their values: one letter, or all but one."""
    options = [list(_lengths(own)) for own in step.values]
    by_place = [
        {choice: sum(bit for value, bit in bits.items() if value[i] in choice) for choice in own}
        for i, own in enumerate(options)
    ]
    boxes = []
    for box in itertools.product(*options):
        mask = (1 << len(bits)) - 1
        for i, choice in enumerate(box):
            mask &= by_place[i][choice]
        boxes.append((box, mask))
    return boxes


def _length(box: Box, values: Box) -> int:
    """Return the number of words of a box, in which a negation counts as more than a word."""
    return sum(_lengths(own)[letters] for letters, own in zip(box, values, strict=True))


@cache
def _lengths(values: str) -> dict[str, int]:
    """Return the letters of a member that have words, with their lengths."""
    lengths = {values: 0}
    for length, is_negated in ((2, False), (3, True)):
        for letters in WORDS["controller"].values():
            own = "".join(each for each in values if (each in letters) != is_negated)
            lengths.setdefault(own, length)
    lengths.pop("", None)
    return lengths
