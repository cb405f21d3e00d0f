"""Signals of a robot: images, resources by name, and their values at a control tick."""

from __future__ import annotations

from cbdsl.backends.cameras.camera_system import camera_errors
from cbdsl.numeric.arrays import Image
from cbdsl.program.binding import bind
from cbdsl.robot.channel_names import channel_names
from cbdsl.robot.pair_names import pair_features
from cbdsl.robot.resources import resources
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners, EpisodeObserver
from cbdsl.runtime.feature_reader import FeatureReader
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.vision.association.stereo import Ray, triangulate
from cbdsl.sensing.vision.regions.camera import heading, within_view
from cbdsl.types.resource import Headings, KernelSample, NetForces, NetLoad, Resource, Tip

__all__ = [
    "ControllerRun", "EpisodeListeners", "EpisodeObserver", "FeatureReader", "Headings",
    "Image", "KernelSample", "NetForces", "NetLoad", "ProgramRun", "Ray", "Resource", "Runner",
    "Signals", "Tick", "Tip", "bind", "camera_errors", "channel_names", "heading",
    "pair_features", "resources", "triangulate", "within_view",
]  # fmt: skip
