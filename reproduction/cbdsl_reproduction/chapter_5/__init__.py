"""Figures and tables of Chapter 5."""
