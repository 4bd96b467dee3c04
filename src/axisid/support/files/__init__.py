"""Files that are read and written: regular ones, unchanged while read, of a size that fits.

In: paths and bytes. Out: contents, hashes, JSON. Its modules are imported by name. Knows nothing
of what a file says.
"""
