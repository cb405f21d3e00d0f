"""Injected causes by which ``cb why`` is judged, without its rules in view."""

from injected_causes import Injection

JUDGED: tuple[Injection, ...] = ()
