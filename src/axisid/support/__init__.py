"""What every room may lean on: errors with their exit codes, notes, progress, arrays.

In: values and what is to be said. Out: arrays, errors, notes and remedies that are worded
later. Its modules are imported by name, so that nothing is loaded that is not used. Knows nothing
of axes.
"""
