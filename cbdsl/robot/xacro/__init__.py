"""Expansion of xacro, the macros in which many robot models are written."""
