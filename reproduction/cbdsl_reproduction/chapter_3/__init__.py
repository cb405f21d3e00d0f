"""Figures and tables of Chapter 3."""
