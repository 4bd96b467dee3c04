"""Candidate terms of the force that `identify` and `fit` test, and the table for your own terms.

A candidate is a `Term`: its name, the declaration to add, and its regressor columns along a motion.
After ``TERMS["ripple"] = Term(kind="ripple", ...)`` the term is tested too.

In: a term. Out: the table of all terms. Knows nothing of how terms are tested.
"""

from axisid.estimation.misspecification import TERMS as TERMS, Along as Along, Term as Term
