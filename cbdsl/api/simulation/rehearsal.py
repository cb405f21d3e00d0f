"""Rehearsals: programs run in simulation first, so that a real robot waits for no machine code."""

from __future__ import annotations

import contextlib
from itertools import islice
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest

# Ticks of a rehearsal: half a minute of the kinematic engine's time.
_TICKS = 600


def rehearse(request: RunRequest, seed: int = 0) -> None:
    """Run a program on the kinematic engine, which loads the compiled functions that it calls.

    Machine code that is loaded within a control tick would break the deadline of a real robot. A
    program that cannot run there is not rehearsed.

    Args:
        request: Program, robot and stage.
        seed: Seed of the episode.
    """
    import scipy.optimize  # noqa: F401 (causes of rest need it, which a rehearsal may lack)

    from cbdsl.backends.backend import embody
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.kinematics.kinematics import Kinematics
    from cbdsl.numeric.compiled import load_kept
    from cbdsl.runtime.episode import Runner

    with contextlib.suppress(UsageError):
        simulated = embody("kinematic", request.robot, request.urdf)
        with contextlib.closing(simulated):
            kinematics = Kinematics(request.robot, request.urdf)
            runner = Runner(request.robot, kinematics, request.program, simulated)
            for _ in islice(runner.ticks(request.stage, seed), _TICKS):
                pass
    # The rehearsal may have ended before the program's last states.
    load_kept()
