"""``axisid identify``, by itself and in blocks, and what it prints and writes.

In: arguments. Out: an exit code, and results printed or written. Its modules are imported by name.
Knows nothing of other commands.
"""
