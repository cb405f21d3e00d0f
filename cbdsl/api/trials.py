"""Trials of learning, episode by episode: bodies, journals, provenance and workers.

``learn_trials`` runs the trials of the shipped learners. These parts run other learners, store
each finished episode before the next one begins, and continue interrupted trials.
"""

from __future__ import annotations

from cbdsl.backends.backend import Backend, embody, find_backend
from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.backends.simulated_backend import simulate as embody_simulated
from cbdsl.runtime.line_journal import DamagedJournalError, JournalError
from cbdsl.training.episode_runner import BackendEpisodeRunner
from cbdsl.training.exploration_task import exploration_journal
from cbdsl.training.journal import Journal
from cbdsl.training.journal_follower import JournalFollower
from cbdsl.training.local_workers import run_on_workers
from cbdsl.training.provenance import TrialSetting, provenance_of, versions
from cbdsl.training.trial import Trial, used_programs
from cbdsl.training.trial_loop import (
    NullObserver,
    TrialObserver,
    identity_of,
    journal_file,
    open_journal,
    run_trial,
)

__all__ = [
    "Backend",
    "BackendEpisodeRunner",
    "DamagedJournalError",
    "Journal",
    "JournalError",
    "JournalFollower",
    "NullObserver",
    "SimulatedBackend",
    "Trial",
    "TrialObserver",
    "TrialSetting",
    "embody",
    "embody_simulated",
    "exploration_journal",
    "find_backend",
    "identity_of",
    "journal_file",
    "open_journal",
    "provenance_of",
    "run_on_workers",
    "run_trial",
    "used_programs",
    "versions",
]
