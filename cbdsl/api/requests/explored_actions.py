"""Actions of ``cb explore``, read from the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from pathlib import Path

    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.documents.catalog import CatalogDocument
    from cbdsl.training.exploration.explorable import Explorable
    from cbdsl.types.resource import Resource


class ActionText(NamedTuple):
    """Action as typed on the command line.

    Attributes:
        label: Name in the catalog.
        program: File or name of a program.
        values: Values of the program's parameters.
    """

    label: str
    program: str
    values: Mapping[str, str]


def read_action(text: str | RunRequest) -> ActionText:
    """Read ``NAME``, ``NAME:key=value,key=value`` or ``LABEL=NAME:...``, or a loaded program.

    Raises:
        UsageError: The text has none of these forms.
    """
    import re
    from pathlib import Path

    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.document import NAME_PATTERN

    if not isinstance(text, str):
        label = "_".join([text.program_file.stem, *text.values.values()])
        return ActionText(label, str(text.program_file), text.values)
    # The colon comes first, because values behind it have equals signs of their own. Without a
    # label, `rpartition` leaves the whole head as the program.
    head, _, tail = text.partition(":")
    label, given, program = head.rpartition("=")
    pairs = [pair.partition("=") for pair in tail.split(",")] if tail else []
    label = (
        label if given else "_".join([Path(program).stem, *(v for _, _, v in pairs if v != "?")])
    )
    if not program or not re.fullmatch(NAME_PATTERN, label) or any(not v for _, _, v in pairs):
        raise UsageError(
            f"'{text}' is not an action; write a program as NAME, NAME:key=value or "
            "LABEL=NAME:key=value"
        )
    return ActionText(label, program, {key: value for key, _, value in pairs})


def read_actions(
    texts: Sequence[str | RunRequest], feature: str, stage: str, folder: Path | None = None
) -> tuple[list[RunRequest], tuple[Explorable, ...]]:
    """Read, check and resolve the actions of an exploration.

    Args:
        texts: Actions as typed, or loaded programs.
        feature: Value of the parameter ``feature`` of actions that do not assign it.
        stage: Stage of the exploration.
        folder: Folder to search for documents by name; the working folder if ``None``.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: A text is not an action, or the action cannot be rewarded.
    """
    from cbdsl.diagnostics.errors import UsageError

    requests: list[RunRequest] = []
    actions: list[Explorable] = []
    for each in map(read_action, texts):
        request, action = _explorable(each, feature, stage, folder)
        if action.name in {known.name for known in actions}:
            raise UsageError(f"two actions are named '{action.name}': give one a LABEL=")
        requests.append(request)
        actions.append(action)
    return requests, tuple(actions)


def recorded_actions(
    catalog: CatalogDocument, stage: str
) -> tuple[RunRequest, tuple[Explorable, ...]]:
    """Resolve the actions of a catalog, as its exploration did.

    An action was open if channels that it found became actions. Its record counts searches for
    channels that had no action, so that it has to search for those again.

    Args:
        catalog: Catalog without findings.
        stage: Stage on which the actions will run.

    Returns:
        Request of the first action, and all actions.
    """
    from cbdsl.training.exploration.explorable import OPEN

    resolved = []
    for name, row in catalog.affordances.items():
        opened = dict.fromkeys(_opened(catalog, name), OPEN)
        text = ActionText(name, row.program, {**row.with_, **opened})
        resolved.append(_explorable(text, catalog.feature, stage))
    return resolved[0][0], tuple(action for _, action in resolved)


# An action `poke` with an open parameter `feature` that finds the channel `red` adds an action
# `poke_red`. Both have the same program and the same values, but for `feature`. Exactly this
# pattern is recognised.
def _opened(catalog: CatalogDocument, name: str) -> set[str]:
    """Return the parameters of an action whose values became actions of their own."""
    row = catalog.affordances[name]
    return {
        key
        for other, mark in catalog.affordances.items()
        for key, value in mark.with_.items()
        if other == f"{name}_{value}"
        and mark.program == row.program
        and {**row.with_, key: value} == mark.with_
    }


def _explorable(
    text: ActionText, feature: str, stage: str, folder: Path | None = None
) -> tuple[RunRequest, Explorable]:
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.training.exploration.explorable import OPEN, with_marks

    open_keys = [key for key, value in text.values.items() if value == OPEN]
    if len(open_keys) > 1:
        raise UsageError(f"'{text.label}' leaves {' and '.join(open_keys)} open: one can be")
    # The searching action itself has no value for the open parameter, and uses the program's
    # default.
    closed = {key: value for key, value in text.values.items() if value != OPEN}
    request, action = bound_action(text._replace(values=closed), feature, stage, folder)
    if not open_keys:
        return request, action

    def bind(label: str, values: Mapping[str, str]) -> Explorable:
        return bound_action(ActionText(label, text.program, values), feature, stage, folder)[1]

    return request, with_marks(text.label, text.values, bind, request.robot)


def bound_action(
    text: ActionText, feature: str, stage: str, folder: Path | None = None
) -> tuple[RunRequest, Explorable]:
    """Return a program with its values, and the features of its model."""
    from cbdsl.api.requests.load_request import LoadOptions
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.program import ProgramDocument
    from cbdsl.training.exploration.explorable import explorable
    from cbdsl.yaml_text.library import Library

    library = Library(folder)
    document = library.read(library.locate(ProgramDocument, text.program), ProgramDocument)
    values = dict(text.values)
    # A value for a parameter that a program does not declare would be an error.
    if "feature" in document.document.parameters:
        values.setdefault("feature", feature)
    options = LoadOptions(stage=stage, values=values, folder=folder)
    request = options.read(text.program)
    action = explorable(text.label, request.program, request.digest, _resources(request))
    if action is None:
        raise UsageError(
            f"'{text.program}' cannot be explored: nothing that it tracks or touches is rewarded"
        )
    return request, action


def _resources(request: RunRequest) -> Mapping[str, Resource]:
    from cbdsl.robot.resources import resources
    from cbdsl.robot.urdf_reader import read_urdf_if_sound

    return resources(request.robot, read_urdf_if_sound(request.urdf))
