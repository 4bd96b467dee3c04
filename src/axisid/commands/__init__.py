"""The command line.

In: arguments. Out: one call, one exit code. Knows nothing of how anything is computed.
"""
