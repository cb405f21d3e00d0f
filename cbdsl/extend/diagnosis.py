"""Diagnoses of recordings, for the entry-point group ``cbdsl.diagnoses``.

An entry is a function of a ``Recorded`` episode that returns the ``MarkedCause`` of each reason for
its failure, the first one first; pages show them. It does not read the ``scene``, which is the
truth of a simulation. The names below read recorded ticks, links, and causes of rest. The contract
test is ``cbdsl.extend.contract.test_diagnosis``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.kinematics.quaternion import product, quaternion_about, turned
    from cbdsl.numeric.arrays import Floats
    from cbdsl.reporting.diagnoses import MarkedCause
    from cbdsl.reporting.drawn_links import placed, read_links
    from cbdsl.reporting.recorded import Recorded, find_recordings, read_recording
    from cbdsl.runtime.causes import (
        BLOCKED,
        CLEARANCE,
        CREEPING,
        LIMITS,
        OPTIMUM,
        OUT_OF_REACH,
        SINGULAR,
    )
    from cbdsl.runtime.fruitless_loop import last_rounds
    from cbdsl.runtime.recording import FLAGS, HOLDERS, SIGHT

__all__ = [
    "BLOCKED", "CLEARANCE", "CREEPING", "FLAGS", "HOLDERS", "LIMITS", "OPTIMUM", "OUT_OF_REACH",
    "SIGHT", "SINGULAR", "Floats", "MarkedCause", "Recorded", "find_recordings", "last_rounds",
    "placed", "product", "quaternion_about", "read_links", "read_recording", "turned",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
