"""Candidate terms that `identify` and `fit` look for, and the table for your own candidates.

A candidate is a `Term`: its name, the declaration to add, and its columns along a motion.
``TERMS["ripple"] = Term(kind="ripple", ...)`` is looked for from then on.

In: a term. Out: the table of all. Knows nothing of how they are tested.
"""

from axisid.estimation.misspecification import TERMS as TERMS, Along as Along, Term as Term
