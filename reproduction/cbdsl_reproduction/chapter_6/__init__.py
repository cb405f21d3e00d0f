"""Figures and tables of Chapter 6."""
