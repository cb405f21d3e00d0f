"""Figures and tables of Chapter 4."""
