"""Public contract of extensions: one module for each entry-point group.

A package that extends cbdsl imports its contract from here, and otherwise from ``cbdsl`` and
``cbdsl.api``; all other modules may change without notice. Each module names the type of its
entries, their units, shapes and errors. ``pytest --pyargs cbdsl.extend -k NAME`` tests an installed
entry.
"""
