# %% [markdown]
# # Gallery of the library axes
#
# Each axis of the library is a short file in `modeling/library`, with generated code and a twin. The figures show the
# twin's measured force and the force reconstructed by IDM-IV. Start your own axis from the most similar one.
#
# Every parameter is separately identifiable, by every method, unless the text says otherwise.

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
    fit = f"IDM-IV on its twin, ± one standard error: {rows}."
    display(Markdown(f"## {name}: {axis.title}\n\n{text_of(name)}\n\n{fit}"))
    figure = result.plot("force")
    figure.set_size_inches(7, 3.2)
    display(figure)
    plt.close(figure)
