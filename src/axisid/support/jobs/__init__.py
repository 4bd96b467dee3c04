"""Many jobs on many workers: none of them harms another, and an interrupt ends them all.

In: a function, items, an executor or a number of processes. Out: an outcome of each item, as they
end. Knows nothing of axes and logs. Its modules are imported by name, so that nothing is loaded
that is not used.
"""
