"""Digest of all inputs of a shipped program's episode, except seed and engine."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.api.documents import digest_of_text
from cbdsl.api.shipped import shipped_program


def trial_digest(program: str, values: Mapping[str, str], stage: str | None) -> str:
    """Return the digest of a shipped program with its dependencies, its robot and a stage.

    Args:
        program: Name of the program.
        values: Values of its parameters.
        stage: Name of a stage; its own if ``None``.
    """
    request = shipped_program(program, stage=stage, values=values)
    parts = (
        str(request.digest),
        # The program's digest does not cover its policy.
        request.program_file.read_text(encoding="utf-8"),
        str(sorted(values.items())),
        request.robot.model_dump_json(),
        request.stage.model_dump_json(),
    )
    return digest_of_text("\n".join(parts))
