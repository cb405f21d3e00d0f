"""Export ``mcap``: recorded episodes as MCAP files for Foxglove."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.extend.export import EXPORTS, Export, UsageError

if TYPE_CHECKING:
    from cbdsl.extend.export import Recorded

#: Message schemas of MCAP files.
SCHEMAS = ("foxglove", "ros2")

Schemas = Annotated[
    str,
    typer.Option(
        "--schemas", help="Message schemas: foxglove (JSON), or ros2, which is cb export ros2."
    ),
]


def write(recordings: Iterable[Recorded], target: Path, *, schemas: Schemas = "foxglove") -> str:
    """Write recorded episodes as MCAP, for Foxglove and other tools.

    The file has joint states, transforms, objects, images, potentials, predicates and transitions,
    by simulated time.
    """
    if schemas not in SCHEMAS:
        raise UsageError.unknown("kind of schemas", schemas, SCHEMAS)
    if schemas == "ros2":
        return EXPORTS.get("ros2").write(recordings, target)
    from cbdsl_mcap.mcap_file import write_mcap

    (recorded,) = recordings
    messages = write_mcap(recorded, target)
    return f"{messages} messages, {target.stat().st_size / 1e6:.1f} MB"


MCAP = Export(write, suffix=".mcap")
