"""Features of the source: position, velocity and volume of an object (Section 5.3.1.1)."""

from __future__ import annotations

from cbdsl.api.program import CheckedProgram

_SOURCE = ("place", "velocity", "volume")


def with_source_features(program: CheckedProgram) -> CheckedProgram:
    """Return a program to assimilate with the source's features alone.

    The product also offers the distance of the object from the arms' bases.
    """
    assert program.schema is not None
    features = {name: each for name, each in program.schema.features.items() if name in _SOURCE}
    return program._replace(schema=program.schema._replace(features=features))
