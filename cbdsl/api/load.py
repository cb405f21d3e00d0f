"""``cbdsl.load``: a program on a stage, checked."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.run_request import RunRequest


def load(
    program: str | Path,
    *,
    stage: str | Path | None = None,
    policy: str | Path | None = None,
    schema: str | Path | None = None,
    calibration: str | Path | None = None,
    body: int | None = None,
    values: Mapping[str, str] | None = None,
) -> RunRequest:
    """Read and check a program, and all that it needs to run.

    Args:
        program: its file, or its name.
        stage: file or name of who is shown what, where; the program's own when ``None``.
        policy: file or name of what chooses its actions; the program's own when ``None``.
        schema: file or name of what chooses its resources, with a policy of its own.
        calibration: file or name of where the cameras are; the robot's own when ``None``.
        body: number of the simulated body, which keeps its cameras' errors.
        values: of the program's parameters, by name, as they are written in documents.

    Raises:
        DiagnosticsError: a document has errors; its ``diagnostics`` are the findings.
        UsageError: there is no such document, or they do not fit each other.
    """
    from cbdsl.api.run_request import read_request
    from cbdsl.errors.errors import UsageError

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
    )


def _word(document: str | Path | None) -> str | None:
    return None if document is None else str(document)
