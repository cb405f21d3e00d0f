"""``cb warm``: compile in advance."""

from __future__ import annotations

import time
from itertools import islice
from typing import TYPE_CHECKING

from cbdsl.api.requests.load_request import LoadOptions
from cbdsl.cli.episodes.simulation import embodied, needing_simulation, ticks_compiled_meanwhile
from cbdsl.cli.process.native_output import shown_on_failure
from cbdsl.cli.process.termination import termination_interrupts
from cbdsl.diagnostics.errors import UsageError

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest

# Programs that together call all compiled functions of control and sensing. They run on the engine
# without physics, which is the fastest.
_PROGRAMS = (
    "reachtouch", "reach", "notice", "bimanualgrab", "bimanualinspect", "impedance", "touch_table",
    "transport_hand",
)  # fmt: skip
# The engines with physics have few compiled functions of their own.
_ON_ENGINES = "reachtouch"
# Clearance of the last run, which has other functions.
_CLEARANCE = "1 cm"
# Number of ticks within which all compiled functions are called.
_TICKS, _TICKS_ON_ENGINES = 200, 40


def warm() -> None:
    """Compile in advance for all installed engines, so that first runs start immediately.

    All environments of the user share the machine code. Exit 0 if it is stored, 2 if it cannot be.
    """
    with needing_simulation():
        from cbdsl.backends.engines import installed_engines
        from cbdsl.cli.output.compilation import told_of_compilation
        from cbdsl.control.potential_registry import compile_potentials
        from cbdsl.numeric.kernel_cache import folder, kept_files, problem
    began, before = time.monotonic(), kept_files()
    with (
        shown_on_failure(),
        termination_interrupts(),
        told_of_compilation(),
        ticks_compiled_meanwhile((None, _CLEARANCE)),
    ):
        compile_potentials()
        for engine in installed_engines():
            _run(LoadOptions().read(_ON_ENGINES), engine, _TICKS_ON_ENGINES)
        for program in _PROGRAMS:
            _run(LoadOptions().read(program), "kinematic", _TICKS)
        request = LoadOptions(clearance=_CLEARANCE).read(_ON_ENGINES)
        _run(request, "kinematic", _TICKS_ON_ENGINES)
    if reason := problem():
        raise UsageError(f"compiled code cannot be kept: {reason}")
    count, seconds = kept_files() - before, time.monotonic() - began
    print(f"{count} functions compiled in {seconds:.0f} s; all are kept in {folder()}")


def _run(request: RunRequest, engine: str, ticks: int) -> None:
    """Run the first ticks of an episode."""
    from cbdsl.runtime.episode import Runner

    cameras = None if engine == "kinematic" else "ideal"
    with embodied(request, engine, cameras=cameras) as (backend, kinematics):
        runner = Runner(request.robot, kinematics, request.program, backend)
        for _ in islice(runner.ticks(request.stage, seed=0), ticks):
            continue
