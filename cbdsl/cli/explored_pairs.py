"""Pairs of objects of ``cb explore --thing``, read from the command line."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import permutations
from typing import TYPE_CHECKING

from cbdsl.api.explored_actions import read_action
from cbdsl.api.run_request import read_request
from cbdsl.checking.knowledge.digest import program_digest
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.document import NAME_PATTERN
from cbdsl.documents.program import ProgramDocument
from cbdsl.robot.pair_names import pair_features
from cbdsl.robot.resources import resources
from cbdsl.robot.urdf_reader import read_urdf_if_sound
from cbdsl.training.explorable_pair import ExplorablePair
from cbdsl.yaml_text.library import Library

if TYPE_CHECKING:
    from cbdsl.api.run_request import RunRequest
    from cbdsl.types.resource import Resource

# Parameters of a program that brings one object to another.
_ENDS = ("feature", "goal")


def read_things(texts: Sequence[str]) -> dict[str, str]:
    """Return the channels of objects by name, from ``NAME=CHANNEL``.

    Raises:
        UsageError: A text has another form, or a name or a channel occurs twice.
    """
    things: dict[str, str] = {}
    for text in texts:
        name, _, channel = text.partition("=")
        if not channel or not re.match(NAME_PATTERN, name):
            raise UsageError(f"--thing {text}: a thing is NAME=CHANNEL, such as ball=red")
        if name in things:
            raise UsageError(f"--thing {text}: '{name}' is there twice")
        if channel in things.values():
            raise UsageError(f"--thing {text}: another thing is known by '{channel}' already")
        things[name] = channel
    if len(things) < 2:
        raise UsageError("--thing: pairs are of two things at least")
    return things


def read_pairs(
    program: str, things: Mapping[str, str], relation: str, stage: str | None
) -> tuple[RunRequest, dict[str, ExplorablePair]]:
    """Return the pairs of objects in the contexts of a stage, with the program bound to both.

    Args:
        program: File or name of a program, optionally with values as in ``NAME:key=value``.
        things: Channels of the objects by name.
        relation: Word between the objects in the name of a context, ``on`` or ``in``.
        stage: File or name of a stage.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: The program does not bring one object to another, or the stage has no pair.
    """
    text = read_action(program)
    requests: dict[str, RunRequest] = {}
    pairs: dict[str, ExplorablePair] = {}
    for upper, lower in permutations(things, 2):
        name = f"{upper}_{relation}_{lower}"
        values = {**text.values, **dict(zip(_ENDS, (things[upper], things[lower]), strict=True))}
        if not requests:
            _require_ends(text.program)
            requests[name] = _request(text.program, stage, values)
        shown = next(iter(requests.values())).stage
        if name in shown.contexts:
            request = requests.get(name) or _request(text.program, stage, values)
            requests[name] = request
            pairs[name] = _pair(upper, lower, name, request)
    if not pairs:
        raise UsageError(
            f"stage '{shown.name}' shows no pair of {', '.join(things)}: "
            f"a context such as '{name}' would"
        )
    return next(iter(requests.values())), pairs


def _request(program: str, stage: str | None, values: Mapping[str, str]) -> RunRequest:
    return read_request(program, stage, None, values)


def _require_ends(program: str) -> None:
    library = Library()
    document = library.read(library.locate(ProgramDocument, program), ProgramDocument).document
    missing = [key for key in _ENDS if key not in document.parameters]
    if missing or not document.success:
        lacks = f"parameter '{missing[0]}'" if missing else "'success'"
        raise UsageError(f"'{program}' brings no thing to another one: it has no {lacks}")


def _pair(upper: str, lower: str, context: str, request: RunRequest) -> ExplorablePair:
    digest = program_digest(request.program_file, request.library)
    return ExplorablePair(upper, lower, context, request.program, digest, _features(request))


def _features(request: RunRequest) -> dict[str, Resource]:
    """Return the signals of both objects, in the first camera and in space."""
    given, camera = request.program.parameters, next(iter(request.robot.cameras), "")
    named = resources(request.robot, read_urdf_if_sound(request.urdf))
    return pair_features(given["feature"], given["goal"], camera, named)
