# %% [markdown]
# # Gallery of the library axes
#
# Axes that ship: each a file of a screenful in `modeling/library`, with generated code and a twin. The figures show the twin's
# measured and reconstructed force by IDM-IV. Start your own from the nearest.
#
# Every parameter has an effect of its own, and every method identifies it, unless something else is said.

# %% tags=["remove-input"]
from IPython.display import Markdown, display
from matplotlib import pyplot as plt

from axisid import identify, load_axis, twin_record
from axisid.modeling import LIBRARY
from axisid.presentation.documents import decimals, readable_unit
from benchmarks.library import prefilter_of
from docs.extensions.axis_texts import text_of

for name in LIBRARY:
    axis = load_axis(name)
    result = identify(axis, twin_record(axis), prefilter_of(name), ["idm-iv"])
    rows = ", ".join(
        f"{n} = {v.corrected:.{decimals(v.deviation)}f} ± {v.deviation:.{decimals(v.deviation)}f} "
        f"{readable_unit(v.unit)}"
        for n, v in result["idm-iv"].parameters.items()
    )
    fit = f"IDM-IV on its twin, ± one standard deviation: {rows}."
    display(Markdown(f"## {name}: {axis.title}\n\n{text_of(name)}\n\n{fit}"))
    figure = result.plot("force")
    figure.set_size_inches(7, 3.2)
    display(figure)
    plt.close(figure)
