"""Figures and tables of Chapter 7."""
