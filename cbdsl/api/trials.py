"""Trials of learning, episode by episode: bodies, journals, provenance and workers.

``learn_trials`` runs the trials of the shipped learners. These parts run other learners, store
each finished episode before the next one begins, and continue interrupted trials.
"""

from __future__ import annotations

from cbdsl.backends.backend import AttendedBackend, Backend, embody, find_backend
from cbdsl.backends.simulated_backend import SimulatedBackend

# `cbdsl.simulate` opens the robot of a program; this function makes a backend alone.
from cbdsl.backends.simulated_backend import simulate as embody_simulated
from cbdsl.learning.experience import EPISODES
from cbdsl.storage.journal import DamagedJournalError, Journal, JournalError
from cbdsl.training.episode_runner import BackendEpisodeRunner
from cbdsl.training.exploration.action_work import FinishedAction
from cbdsl.training.provenance import TrialSetting, provenance_of, versions
from cbdsl.training.task_files import exploration_journal, trial_journal
from cbdsl.training.task_observer import ItemListener, TaskObserver
from cbdsl.training.trial import Trial, used_programs
from cbdsl.training.trial_work import identity_of, open_journal, run_trial
from cbdsl.training.workers.local_workers import run_on_workers

__all__ = [
    "EPISODES", "AttendedBackend", "Backend", "BackendEpisodeRunner", "DamagedJournalError",
    "FinishedAction", "ItemListener", "Journal", "JournalError", "SimulatedBackend",
    "TaskObserver", "Trial", "TrialSetting", "embody", "embody_simulated",
    "exploration_journal", "find_backend", "identity_of", "open_journal", "provenance_of",
    "run_on_workers", "run_trial", "trial_journal", "used_programs", "versions",
]  # fmt: skip
