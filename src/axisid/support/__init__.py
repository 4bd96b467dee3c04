"""Shared basis of all packages: errors, checks of arguments, files, libraries, caches, arrays.

In: values, and parts of messages. Out: arrays, errors, texts, written files. Its modules are
imported by name, so that nothing is loaded that is not used. Knows nothing of axes.
"""
