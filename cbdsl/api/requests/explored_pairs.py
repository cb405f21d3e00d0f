"""Pairs of objects of an exploration: their contexts, and the program that brings them together."""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import permutations
from typing import TYPE_CHECKING

from cbdsl.api.requests.explored_actions import read_action
from cbdsl.api.requests.run_request import read_request
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.document import NAME_PATTERN
from cbdsl.documents.program import ProgramDocument
from cbdsl.robot.pair_names import pair_features
from cbdsl.robot.resources import resources
from cbdsl.robot.urdf_reader import read_urdf_if_sound
from cbdsl.training.exploration.explorable_pair import ExplorablePair
from cbdsl.yaml_text.library import Library

if TYPE_CHECKING:
    from pathlib import Path

    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.types.resource import Resource

# Parameters of a program that brings one object to another.
_ENDS = ("feature", "goal")


def require_things(things: Mapping[str, str]) -> None:
    """Check that objects have distinct channels and make pairs.

    Args:
        things: Channels of the objects by name.

    Raises:
        UsageError: A name is not allowed, a channel occurs twice, or there is one object.
    """
    channels: set[str] = set()
    for name, channel in things.items():
        if not channel or not re.fullmatch(NAME_PATTERN, name):
            raise UsageError(f"thing '{name}': a name and its channel, such as ball and red")
        if channel in channels:
            raise UsageError(f"thing '{name}': another thing has the channel '{channel}'")
        channels.add(channel)
    if len(things) < 2:
        raise UsageError("pairs are of two things at least")


def read_pairs(
    program: str,
    things: Mapping[str, str],
    relation: str,
    stage: str | None,
    folder: Path | None = None,
) -> tuple[RunRequest, dict[str, ExplorablePair]]:
    """Return the pairs of objects in the contexts of a stage, with the program bound to both.

    Args:
        program: File or name of a program, optionally with values as in ``NAME:key=value``.
        things: Channels of the objects by name.
        relation: Word between the objects in the name of a context, ``on`` or ``in``.
        stage: File or name of a stage.
        folder: Folder to search for documents by name; the working folder if ``None``.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: The program does not bring one object to another, or the stage has no pair.
    """
    text = read_action(program)
    requests: dict[str, RunRequest] = {}
    pairs: dict[str, ExplorablePair] = {}
    # Pairs are ordered: a ball on a box is another pair than a box on a ball.
    for upper, lower in permutations(things, 2):
        name = f"{upper}_{relation}_{lower}"
        values = {**text.values, **dict(zip(_ENDS, (things[upper], things[lower]), strict=True))}
        # The first request is read even if its pair is not on the stage. Without `stage`, only a
        # request knows the stage of its program.
        if not requests:
            _require_ends(text.program, folder)
            requests[name] = _request(text.program, stage, values, folder)
        shown = next(iter(requests.values())).stage
        if name in shown.contexts:
            request = requests.get(name) or _request(text.program, stage, values, folder)
            requests[name] = request
            pairs[name] = _pair(upper, lower, name, request)
    if not pairs:
        raise UsageError(
            f"stage '{shown.name}' shows no pair of {', '.join(things)}: "
            f"a context such as '{name}' would"
        )
    return next(iter(requests.values())), pairs


def _request(
    program: str, stage: str | None, values: Mapping[str, str], folder: Path | None
) -> RunRequest:

    return read_request(program, stage, None, values, folder=folder)


def _require_ends(program: str, folder: Path | None) -> None:

    library = Library(folder)
    document = library.read(library.locate(ProgramDocument, program), ProgramDocument).document
    missing = [key for key in _ENDS if key not in document.parameters]
    if missing or not document.success:
        lacks = f"parameter '{missing[0]}'" if missing else "'success'"
        raise UsageError(f"'{program}' brings no thing to another one: it has no {lacks}")


def _pair(upper: str, lower: str, context: str, request: RunRequest) -> ExplorablePair:

    program, digest = request.program, request.digest
    return ExplorablePair(upper, lower, context, program, digest, _features(request))


def _features(request: RunRequest) -> dict[str, Resource]:
    """Return the signals of both objects, in the first camera and in space."""
    given, camera = request.program.parameters, next(iter(request.robot.cameras), "")
    named = resources(request.robot, read_urdf_if_sound(request.urdf))
    return pair_features(given["feature"], given["goal"], camera, named)
