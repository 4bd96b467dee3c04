# %% [markdown]
# # Gallery of the library axes
#
# Axes that ship: each a file of a screenful in `modeling/library`, with generated code, a page and a twin.
# The figures show the twin's measured and reconstructed force by IDM-IV. Start your own from the nearest.

# %% tags=["remove-input"]
from IPython.display import Markdown, display
from matplotlib import pyplot as plt

from axisid import identify, load_axis, twin_record
from axisid.modeling import LIBRARY
from axisid.presentation.formulas import decimals, readable_unit, significant
from axisid.presentation.formulas.latex import equation_latex
from benchmarks.library import prefilter_of

for name in LIBRARY:
    axis = load_axis(name)
    result = identify(axis, twin_record(axis), prefilter_of(name), ["idm-iv"])
    rows = ", ".join(
        f"{n} = {v.corrected:.{decimals(v.deviation)}f} ± {significant(v.deviation)} "
        f"{readable_unit(v.unit)}"
        for n, v in result["idm-iv"].parameters.items()
    )
    heading = f"## [{name}](axes/{name}.md): {axis.title}"
    display(
        Markdown(
            f"{heading}\n\n{equation_latex(axis)}\n\nIDM-IV on its twin, ± one standard deviation: {rows}."
        )
    )
    figure = result.plot("force")
    figure.set_size_inches(7, 3.2)
    display(figure)
    plt.close(figure)

# %% [markdown]
# ```{toctree}
# :caption: Pages
# :maxdepth: 1
#
# axes/emps2015
# axes/emps
# axes/pendulum
# axes/vertical_screw
# axes/belt_axis
# axes/rotary_table
# axes/valve
# axes/crank
# axes/linear_motor
# axes/balanced_slide
# ```
