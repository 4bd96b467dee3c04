"""Commands of many logs, of many twins or of many results.

In: argv. Out: one call, one exit code. Knows nothing of how it is computed. Its modules are
imported by name, so that nothing is loaded that is not used.
"""
