"""Hypothesis strategies for the things this program reads and derives."""
