"""Recorded episodes as datasets of LeRobot."""
