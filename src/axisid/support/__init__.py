"""Shared basis of all rooms: errors, checks of arguments, files, libraries, caches, arrays.

In: values and what is to be said. Out: arrays, errors, notes and remedies that are worded
later. Its modules are imported by name, so that nothing is loaded that is not used. Knows nothing
of axes.
"""
