"""The table of all codes: messages, ``cb explain`` and the tests read it."""

from __future__ import annotations

from cbdsl.errors.codes.compositions import COMPOSITIONS
from cbdsl.errors.codes.controllers import CONTROLLERS
from cbdsl.errors.codes.fields import FIELDS
from cbdsl.errors.codes.ignores import IGNORES
from cbdsl.errors.codes.policies import POLICIES
from cbdsl.errors.codes.programs import PROGRAMS
from cbdsl.errors.codes.reading import READING
from cbdsl.errors.codes.robots import ROBOTS
from cbdsl.errors.codes.shape import SHAPE
from cbdsl.errors.codes.stages import STAGES
from cbdsl.errors.codes.unused import UNUSED
from cbdsl.errors.entry import Entry

CATALOGUE: dict[str, Entry] = {
    entry.code: entry
    for subject in (
        READING,
        SHAPE,
        ROBOTS,
        STAGES,
        COMPOSITIONS,
        CONTROLLERS,
        FIELDS,
        PROGRAMS,
        POLICIES,
        UNUSED,
        IGNORES,
    )
    for entry in subject
}
