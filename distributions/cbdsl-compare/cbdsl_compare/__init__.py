"""Paired comparisons: the same seeds for two programs, until the difference is decided."""
