"""``cbdsl.load``: a program on a stage, checked."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest


def load(
    program: str | Path,
    *,
    stage: str | Path | None = None,
    policy: str | Path | None = None,
    schema: str | Path | None = None,
    calibration: str | Path | None = None,
    body: int | None = None,
    clearance: str | None = None,
    values: Mapping[str, str] | None = None,
    folder: Path | None = None,
) -> RunRequest:
    """Read and check a program and all documents that it needs to run.

    Args:
        program: File or name of the program.
        stage: File or name of the stage to run on; the program's own if ``None``.
        policy: File or name of the policy that chooses its actions; the program's own if ``None``.
        schema: File or name of the schema that chooses its resources, with a policy of its own.
        calibration: File or name of the cameras' calibration; the robot's own if ``None``.
        body: Number of the simulated body, which keeps its cameras' errors.
        clearance: Least distance between links, such as ``2 cm``; the program's if ``None``.
        values: Values of the program's parameters, by name, as written in documents.
        folder: Folder to search for documents by name before the shipped ones; the working folder
            if ``None``.

    Raises:
        DiagnosticsError: A document has errors; its ``diagnostics`` list them.
        UsageError: There is no such document, or the documents do not fit each other.
    """
    from cbdsl.api.requests.run_request import read_request
    from cbdsl.diagnostics.errors import UsageError

    if policy is not None and schema is not None:
        raise UsageError("a schema names its policy: give policy or schema, not both")
    return read_request(
        str(program),
        _word(stage),
        _word(policy),
        dict(values or {}),
        schema=_word(schema),
        calibration=_word(calibration),
        body=body,
        clearance=clearance,
        folder=folder,
    )


def _word(document: str | Path | None) -> str | None:
    return None if document is None else str(document)
