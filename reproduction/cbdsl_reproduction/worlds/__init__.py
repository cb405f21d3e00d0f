"""Worlds of other projects, in which programs run and whose own tests of success judge."""
