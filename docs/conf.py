"""How Sphinx builds the documentation: `make docs`, or ``sphinx-build -W docs build/docs``."""

import os
import sys
from pathlib import Path

import axisid

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE / "extensions"), str(HERE.parent)]
os.environ["PYTHONPATH"] = str(HERE.parent)
# Pages run the command line that belongs to this interpreter.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])

project = "axisid"
author = "The axisid developers"
version = release = axisid.__version__
project_copyright = "The axisid developers"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "mathml",
    "references",
]
exclude_patterns = [
    "conf.py",
    "results_schema.py",
    "readme_figures.py",
    "extensions/**",
]
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb", ".py": "myst-nb"}
# An unused reference of the bibliography is no mistake.
suppress_warnings = ["ref.citation"]

# Pages that are programs: Jupytext's percent format, run anew at every build.
nb_custom_formats = {".py": ["jupytext.reads", {"fmt": "py:percent"}]}
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_execution_show_tb = True
nb_merge_streams = True
nb_render_markdown_format = "myst"

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
default_role = "literal"

html_theme = "furo"
html_title = f"axisid {version}"
html_copy_source = False
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["pages.css"]
