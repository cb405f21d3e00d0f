"""Calibration of a robot's cameras by views of a ball in its hand."""

from cbdsl_calibration.calibrate import CalibrationOutcome, calibrate
from cbdsl_calibration.calibrate_request import CalibrateRequest

__all__ = ["CalibrateRequest", "CalibrationOutcome", "calibrate"]
