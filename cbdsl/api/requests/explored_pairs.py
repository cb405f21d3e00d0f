"""Pairs of objects of an exploration: their contexts, and the program that brings them together."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations
from typing import TYPE_CHECKING

from cbdsl.api.requests.explored_actions import read_action
from cbdsl.api.requests.explored_things import ExploredThing, values_of
from cbdsl.api.requests.load_request import LoadOptions
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.steps import compiled
from cbdsl.robot.pair_names import pair_features
from cbdsl.robot.resources import resources
from cbdsl.robot.urdf_reader import read_urdf_if_sound
from cbdsl.training.exploration.explorable_pair import ExplorablePair
from cbdsl.yaml_text.library import Library

if TYPE_CHECKING:
    from pathlib import Path

    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.types.resource import Resource

# Parameters of a program that brings one object to another, and of one that brings it to a stack.
_ENDS = ("feature", "goal")
_OF_STACK = ("base", "pair")


def read_pairs(
    program: str,
    things: Mapping[str, ExploredThing],
    relation: str,
    stage: str | None,
    folder: Path | None = None,
) -> tuple[RunRequest, dict[str, ExplorablePair]]:
    """Return the pairs of objects in the contexts of a stage, with the program bound to both.

    Args:
        program: File or name of a program, optionally with values as in ``NAME:key=value``.
        things: Objects by name.
        relation: Word between the objects in the name of a context, ``on`` or ``in``.
        stage: File or name of a stage.
        folder: Folder to search for documents by name; the working folder if ``None``.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: The program does not bring one object to another or to a stack, or the stage
            shows no pair.
    """
    text = read_action(program)

    def read(values: Mapping[str, str]) -> RunRequest:
        return LoadOptions(stage=stage, values=values, folder=folder).read(text.program)

    requests: dict[str, RunRequest] = {}
    pairs: dict[str, ExplorablePair] = {}
    # Pairs are ordered: a ball on a box is another pair than a box on a ball.
    for upper, lower in permutations(things, 2):
        name = f"{upper}_{relation}_{lower}"
        # A hand takes a single object, so that a stack is always the lower one.
        if things[upper].base:
            continue
        values = {**text.values, **dict(values_of(things[upper], things[lower], lower))}
        # The first request is read even if its pair is not on the stage. Without `stage`, only a
        # request knows the stage of its program.
        if not requests:
            _require_ends(text.program, things, folder)
            requests[name] = read(values)
        shown = next(iter(requests.values())).stage
        if name in shown.contexts:
            request = requests.get(name) or read(values)
            requests[name] = request
            pairs[name] = _pair(upper, lower, name, request, things[lower])
    if not pairs:
        raise UsageError(
            f"stage '{shown.name}' shows no pair of {', '.join(things)}: "
            f"a context such as '{name}' would"
        )
    return next(iter(requests.values())), pairs


def _require_ends(program: str, things: Mapping[str, ExploredThing], folder: Path | None) -> None:
    library = Library(folder)
    document = library.read(library.locate(ProgramDocument, program), ProgramDocument).document
    missing = [key for key in _ENDS if key not in document.parameters]
    if missing or not compiled(document).success:
        lacks = f"parameter '{missing[0]}'" if missing else "'success'"
        raise UsageError(f"'{program}' brings no thing to another one: it has no {lacks}")
    for name, thing in things.items():
        if thing.base:
            _require_stack(name, thing, document)


def _require_stack(name: str, thing: ExploredThing, program: ProgramDocument) -> None:
    """Check that a program can recognise a stack and set an object on it."""
    missing = [key for key in _OF_STACK if key not in program.parameters]
    if missing:
        raise UsageError(
            f"thing '{name}': '{program.name}' brings no thing to a stack: "
            f"it has no parameter '{missing[0]}'"
        )
    if program.meta_catalog != thing.meta_catalog:
        raise UsageError(
            f"thing '{name}': '{program.name}' knows the pairs of "
            f"'{program.meta_catalog or 'no meta-catalog'}', not of '{thing.meta_catalog}'"
        )


def _pair(
    upper: str, lower: str, context: str, request: RunRequest, below: ExploredThing
) -> ExplorablePair:
    program, digest, features = request.program, request.digest, _features(request, below)
    return ExplorablePair(upper, lower, context, program, digest, features)


def _features(request: RunRequest, below: ExploredThing) -> dict[str, Resource]:
    """Return the signals of both objects, in the first camera and in space.

    Those of a stack's two parts follow: the stack is one object only while it stands.
    """
    given, camera = request.program.parameters, next(iter(request.robot.main_cameras), "")
    named = resources(request.robot, read_urdf_if_sound(request.urdf))
    features = pair_features(given["feature"], given["goal"], camera, named)
    if below.base:
        parts = pair_features(given["goal"], below.base, camera, named)
        features |= {f"stack_{key}": signal for key, signal in parts.items()}
    return features
