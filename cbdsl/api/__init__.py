"""Verbs of cbdsl in Python: load, check, run and learn, with typed results."""
