"""What commands share: arguments and options, what they read and where they write.

In: words of the command line. Out: an axis, a record, settings; files written. Knows nothing of
what a command does with them, and of how a result looks. Its modules are imported by name, so that
nothing is loaded that is not used.
"""
