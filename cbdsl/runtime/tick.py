"""Tick: the state of an episode after one control tick."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals


class Tick(NamedTuple):
    """State of an episode after a control tick, for observers."""

    observation: Observation
    signals: Signals
    run: ProgramRun
    actuation: Actuation
