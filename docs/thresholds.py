# %% [markdown]
# # Thresholds
#
# A threshold decides whether a check passes, a note is written, a log is refused or repaired, a parameter is not
# identifiable, or a compiled library is used. This page lists thresholds with a source outside of this program, and
# thresholds of several modules. Each is one row of `axisid.estimation.thresholds`. The page prints the rows from the
# code, with the modules that use them. A threshold of one module that is only chosen or measured is a constant next to
# its use, with the reason.
#
# The unit is 1 for a ratio or a share; the text next to it names the reference of the share. The *source* shows how well
# founded a number is:
#
# - a key of the [references](references.md);
# - *derived* from the tested quantity;
# - *measured*;
# - *convention*, if others use the same number;
# - *chosen*, if nothing more is known, with the reason if there is one.
#
# Settings of computations, such as numbers of iterations, steps of differences or sizes of windows, are not thresholds.

# %% tags=["hide-input"]
from IPython.display import Markdown, display

from docs.extensions.threshold_tables import page

display(Markdown(page()))
