"""Calibration of cameras by views of the robot's own hand."""
