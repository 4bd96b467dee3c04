"""Estimates for other programs: feed-forward functions and tables.

In: an identification or a file of one. Out: text. Knows nothing of records, and of how its text is
run or shown. Its modules are imported by name, so that help and completion know the targets without
what writes them.
"""
