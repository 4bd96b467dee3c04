"""The numbers by which something is judged: each once, with its unit, its meaning and its source.

In: nothing. Out: rows of `Threshold`, by subject; the documentation prints them. Knows nothing of
who judges by them. What merely sets how a computation goes (bytes, iterations, step sizes, windows)
is no judgement and stays with the computation.
"""
