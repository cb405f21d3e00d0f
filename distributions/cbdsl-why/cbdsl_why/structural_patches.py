"""Changes of the structure of a program: exits of its steps, and its effectors."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import islice, product
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from cbdsl.extend.document import Fix, lines_of, replaced

if TYPE_CHECKING:
    from cbdsl.extend.document import Node, Place, RobotDocument

#: Families of structural changes; a change of a number has its key as its family.
EXITS, ALLOCATION = "exits", "allocation"

Keys = tuple[str | int, ...]

# Largest number of combinations of effectors that are tried.
_MOST_CHOICES = 30


class Patch(NamedTuple):
    """Change of a document: file, line, path of keys, and value before and after.

    Attributes:
        family: Key of a changed number, or the family of a structural change.
        text: Text of the changed document.
    """

    file: Path
    line: int
    keys: Keys
    before: str
    after: str
    text: str
    family: str

    def __str__(self) -> str:
        keys = ".".join(map(str, self.keys))
        return f"{self.file}:{self.line} {keys}: {self.before} -> {self.after}"


class PatchedText(NamedTuple):
    """Text of a document that is changed: its file, text and nodes."""

    file: Path
    text: str
    root: Node

    def written(self, place: Place) -> str:
        """Return the text at a place in one line."""
        return lines_of(self.text)[place.line - 1][place.column - 1 : place.end_column - 1]

    def patch(self, family: str, keys: Keys, changes: Sequence[tuple[Place, str]]) -> Patch:
        """Return the change of the texts at some places to others."""
        fixes = [Fix(p.line, p.column, p.end_column, after) for p, after in changes]
        before = ", ".join(self.written(place) for place, _ in changes)
        after, text = ", ".join(after for _, after in changes), replaced(self.text, fixes)
        return Patch(self.file, fixes[0].line, keys, before, after, text, family)

    def insertion(self, family: str, keys: Keys, node: Node, value: str) -> Patch:
        """Return the insertion of the last of some keys as the first one of a mapping."""
        entry = f"{keys[-1]}: {value}"
        place, first = node.place, next(iter(node.keys.values()))
        if lines_of(self.text)[place.line - 1][place.column - 1 :].startswith("{"):
            fix = Fix(place.line, place.column + 1, place.column + 1, f"{entry}, ")
        else:
            indent = " " * (first.column - 1)
            fix = Fix(first.line, first.column, first.column, f"{entry}\n{indent}")
        return Patch(self.file, fix.line, keys, "none", value, replaced(self.text, [fix]), family)


# An exit may lead back, to try again, but skip no step: a program that reaches its end without a
# step of it would seem to succeed. The distance of a step is its least number of exits to success,
# and no exit to success is removed or made.
def changed_exits(whole: PatchedText, recent: Sequence[str] = ()) -> Iterator[Patch]:
    """Yield the changes of one exit of a step to another step, and new exits of failed steps.

    Args:
        whole: Text of a program.
        recent: Steps of the failed episode, the last one first; their exits come first.
    """
    content = whole.root.value
    steps = content.get("steps") if isinstance(content, dict) else None
    if steps is None or not isinstance(steps.value, dict):
        return
    exits = {name: list(_exits(node)) for name, node in steps.value.items()}
    far = _distances({name: [to for _, to, _ in each] for name, each in exits.items()})
    order = {name: place for place, name in reversed(list(enumerate(recent)))}
    for name in sorted(exits, key=lambda name: order.get(name, len(order))):
        keys = ("steps", name)
        back = [other for other in exits if far[other] >= far[name]]
        # Ends without success are the likeliest faults, then missing exits.
        for key, to, node in exits[name]:
            for other in back if to not in exits and to != "succeed" else ():
                yield whole.patch(EXITS, (*keys, *key), [(node.place, other)])
        section = steps.value[name]
        for other in back if section.keys and "failed" not in section.keys else ():
            yield whole.insertion(EXITS, (*keys, "failed"), section, other)
        for key, to, node in exits[name]:
            for other in exits if to in exits else ():
                if other != to and far[other] >= far[to]:
                    yield whole.patch(EXITS, (*keys, *key), [(node.place, other)])


def _exits(section: Node) -> Iterator[tuple[Keys, str, Node]]:
    """Yield the exits of a step: keys, target, and its scalar."""
    for key, value in section.steps():
        if key in ("then", "failed"):
            yield (key,), str(value.value), value
        elif key == "exits":
            for i, entry in value.steps():
                for when, to in entry.steps():
                    if to.place.end_column:
                        yield ("exits", i, when), str(to.value), to


def _distances(targets: Mapping[str, Collection[str]]) -> dict[str, int]:
    """Return the least number of exits from each step to success; all steps if there is no way."""
    far = dict.fromkeys(targets, len(targets))
    for distance in range(1, len(targets)):
        for name, tos in targets.items():
            if any(to == "succeed" or far.get(to, len(far)) < distance for to in tos):
                far[name] = min(far[name], distance)
    return far


def changed_allocations(
    whole: PatchedText, robot: RobotDocument, given: Collection[str] = ()
) -> Iterator[Patch]:
    """Yield the changes of all effectors that parameters name to others of as many joints.

    Args:
        whole: Text of a program.
        robot: Robot that runs it.
        given: Parameters with other values than these.
    """
    content = whole.root.value
    values = content.get("parameters") if isinstance(content, dict) else None
    nodes = {} if values is None or not isinstance(values.value, dict) else values.value
    ours = [
        (key, node)
        for key, node in nodes.items()
        if node.value in robot.effectors and key not in given
    ]
    others = [_alike(str(node.value), robot) for _, node in ours]
    # Their number grows exponentially with the effectors, and few are tried.
    for choice in islice(product(*others), _MOST_CHOICES) if ours else ():
        if len(set(choice)) == len({node.value for _, node in ours}):
            names = ", ".join(key for key, _ in ours)
            changes = [(node.place, after) for (_, node), after in zip(ours, choice, strict=True)]
            yield whole.patch(ALLOCATION, ("parameters", names), changes)


def _alike(name: str, robot: RobotDocument) -> list[str]:
    def kind(each: str) -> tuple[int, bool]:
        effector = robot.effectors[each]
        return len(effector.joints), effector.tip is None

    return [each for each in robot.effectors if each != name and kind(each) == kind(name)]
