"""Robots with the interface of LeRobot as backends."""
