# %% [markdown]
# # Thresholds
#
# Numbers by which something is judged (a check passes, a note is written, a log is refused or
# repaired, a column counts as not shown, a compiled library is taken) and that have a source outside of
# this program, or by which several parts of it judge. Each is one row of `axisid.estimation.thresholds`, and this
# page prints the rows as they are in the code, with the modules that judge by them. A number that is only chosen or measured, for one part, is a constant
# beside what judges by it, with the reason.
#
# The unit is 1 for a ratio or a share; what it is a share of is said beside it. The *source* says how much a
# number is worth: a key of the [references](references.md); *derived*, where it follows from what is judged;
# *measured*; *convention*, where others use the same; *chosen*, where nothing more is known, with the reason
# if there is one. What only sets how a computation goes, such as numbers of iterations, steps of differences or
# sizes of windows, is no judgement and not listed.

# %% tags=["hide-input"]
from IPython.display import Markdown, display

from docs.extensions.threshold_tables import page

display(Markdown(page()))
