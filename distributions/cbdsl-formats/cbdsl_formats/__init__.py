"""Expansion of xacro, a macro language of robot models."""
