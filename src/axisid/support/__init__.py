"""What every room may lean on: errors with their exit codes, files, progress, arrays.

Its modules are imported by name, so that nothing is loaded that is not used.
Knows nothing of axes.
"""
