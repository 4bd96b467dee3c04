"""The command line.

In: arguments. Out: one call, one exit code. Computes nothing.
"""
