"""Calibration: a robot estimates where its cameras are from what its own hand shows them."""
