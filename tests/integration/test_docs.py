"""What a build of the documentation does not check by itself."""

import re
from pathlib import Path

import axisid
from tests.faces import FACES, public_names

#: Programs in the folder that are no pages.
WRITERS = ("conf.py", "axis_pages.py", "readme_figures.py", "results_schema.py")


def test_every_public_name_is_in_the_api_reference(root: Path) -> None:
    text = "\n".join(page.read_text() for page in (root / "docs" / "api").glob("*.md"))
    listed = set(re.findall(r"\b(axisid\.[\w.]+)$", text, re.MULTILINE))
    public = {f"{face}.{name}" for face in FACES for name in public_names(face)}
    carried = {
        *(f"axisid.support.remedy.{name}" for name in ("Note", "Remedy", "Setting")),  # by errors
        *(
            f"axisid.presentation.saved.Saved{of}"
            for of in ("Identification", "Estimate", "MonteCarlo", "OutputFit")
        ),
        *("axisid.fleets.Fleet", "axisid.trends.Trend"),
        *(f"axisid.twins.{name}" for name in ("TwinMachines", "write_twin", "write_twins")),
    }
    assert listed == public - {*FACES, "axisid.__version__"} | carried


def test_pages_that_are_programs_say_what_they_are_in_their_first_cell(root: Path) -> None:
    pages = [*(root / "docs").glob("*.py"), *(root / "docs" / "howto").glob("*.py")]
    programs = [page for page in pages if page.name not in WRITERS]
    assert len(programs) >= 8
    for page in programs:
        assert page.read_text().startswith("# %% [markdown]\n# # "), page


def test_gallery_has_every_library_axis(root: Path) -> None:
    listed = re.findall(r"^# axes/(\w+)$", (root / "docs" / "gallery.py").read_text(), re.MULTILINE)
    assert listed == list(axisid.modeling.LIBRARY)


def test_pages_need_no_network(root: Path) -> None:
    """Formulas, fonts and scripts come with the pages."""
    text = (root / "docs" / "conf.py").read_text()
    assert "http" not in text.replace("https_proxy", "")
    assert 'html_math_renderer = "mathml"' in text


def test_every_place_that_contributors_are_sent_to_is_there(root: Path) -> None:
    text = (root / "CONTRIBUTING.md").read_text()
    folders = "modeling|codegen|estimation|src|tests|docs|benchmarks"
    named = {*re.findall(rf"`((?:{folders})/[\w/.]+\.(?:py|c|js))`", text)}
    absent = {place for place in named if "NAME" not in place and not (root / place).exists()}
    added = {  # by the recipes
        "estimation/logs/daq.py",
        "estimation/methods/weighted.py",
        "estimation/regression/leave_one_out.py",
        "estimation/diagnostics/turns.py",
        "codegen/printers/javascript.py",
    }
    assert len(named) > 25
    assert absent == added


def test_rows_that_recipes_add_to_tables_are_where_they_say(root: Path) -> None:
    text = (root / "CONTRIBUTING.md").read_text()
    tables = re.findall(r"`([A-Z_]+)` (?:of|in)\s+`([\w/.]+\.py)`", text)
    assert {name for name, _ in tables} >= {
        "FORMATS",
        "METHOD_ROWS",
        "COVARIANCE_ROWS",
        "DIAGNOSTICS",
        "TARGETS",
    }
    for name, place in tables:
        assert re.search(rf"^{name}\b.*= ", (root / place).read_text(), re.MULTILINE), name
