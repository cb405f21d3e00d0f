"""Modifiers of cbdsl's own, each in a file of its own."""
