"""Formats of other tools for recordings, for the entry-point group ``cbdsl.exports``.

An entry is an ``Export``; its function writes ``Recorded`` episodes, whose files are described in
`docs/documents/recording.md`. It raises ``UsageError`` for recordings that it cannot write, and
OSError if the target cannot be written; it replaces a target only when it is complete. The names
below read the robot's links, describe states in words, and write files. The contract test is
``cbdsl.extend.contract.test_export``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.kinematics.quaternion import inverse, product, quaternion_about, turned
    from cbdsl.numeric.arrays import Floats
    from cbdsl.program.transition import title_of
    from cbdsl.program.uses import of_use
    from cbdsl.reporting.automaton_text import automata, member_kinds, state_text, transition_text
    from cbdsl.reporting.drawn_links import DrawnLink, placed, read_links
    from cbdsl.reporting.export_format import EXPORTS, Export
    from cbdsl.reporting.recorded import Recorded
    from cbdsl.storage.atomic_file import replace_file

__all__ = [
    "EXPORTS", "DrawnLink", "Export", "Floats", "Recorded", "UsageError", "automata", "inverse",
    "member_kinds", "of_use", "placed", "product", "quaternion_about", "read_links", "replace_file",
    "state_text", "title_of", "transition_text", "turned",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
