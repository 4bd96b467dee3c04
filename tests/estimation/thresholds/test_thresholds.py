"""Every number by which something is judged is a row of one table, used, sourced and documented."""

import ast
import re
from pathlib import Path

import pytest

from axisid.codegen.thresholds.threshold import Threshold
from docs.extensions.threshold_tables import ROOMS, SUBJECTS, page, rows_of, users

ROWS = {name: row for subject in SUBJECTS for name, row in rows_of(subject).items()}
#: Floats of modules that judge, which are none of their judgements, and why.
IMPLEMENTATION = {
    "held_out_motion._HORIZON": "how long an axis is left to itself",
    "drive_check._SHARES": "the controls that are tried",
    "drive_check._POSITIONS": "the positions that are tried",
    "drive_check._VELOCITIES": "the velocities that are tried",
    "drive_check._LEAST": "what has digits at all",
    "drive_check._STEP": "step of a difference",
    "declared_check._ANYWHERE": "the motions that are tried",
    "declared_check._BESIDE": "how near to a zero is tried",
    "declared_check._RECORDED": "signals that are tried",
    "drive_gain._SAME": "digits of a force",
    "drive_gain._NEXT_TO_0": "what a search does not step to",
    "drive_check._RECORDED": "signals that are tried",
    "compiler._SECONDS": "how long a compiler is waited for",
    "library_cache._LOCK_SECONDS": "how long a lock is waited for",
    "library_cache._OLD_SECONDS": "when what is left of a build is swept away",
    "lanes_check._DELAY": "the delay that is tried",
    "served._CLEARLY": "which lanes are looked at alone, by what a record alone is",
    "regression._MOST_CONDITION": "which lanes are solved alone, by more digits",
    "self_test._LARGE": "which of the points are tried at which size",
    "self_test._STEP": "the step that is tried",
    "self_test._CUT": "how a step is cut",
    "self_test._LITTLE": "step of a difference",
    "self_test._RATE": "signals that are tried",
    "slices._SECONDS": "how long a part of the work runs",
    "slices._WAIT": "how long a look waits",
    "slices._SHORT": "what is run at once",
    "loop_start._CLOSE": "rounding of a control",
    "two_clocks._COINCIDES": "rounding of a time",
    "position_zero._STEP": "step of a difference",
    "ended._EXPONENTIAL": "where a normal's tail is an exponential to rounding",
    "forms._TRACKING": "where a search of a law's filters begins",
    "forms._FILTERS": "where a search of a law's filters begins",
    "measured_motion._STILL": "where a search ends",
    "autoregressive._RESOLVED": "where a search ends",
    "autoregressive._FORGOTTEN": "where a sum ends",
    "measured_motion._FARTHEST": "how far a search goes",
    "measured_motion._TINY": "what there is to divide by",
    "start_position._STEP": "step of a difference",
    "law_gains._STEP": "step of a difference",
    "law_gains._STILL": "where an iteration ends",
    "law_gains._EXACT": "where an iteration ends",
    "law_gains._LARGEST": "how long a step of an iteration is",
    "law_gains._CLEAR": "rounding of a column",
    "by_runs._LARGEST": "whose exponential is a number",
    "terms._COINCIDES": "rounding of a time",
    "signals_apart._STEP": "step of a difference",
    "signals_apart._TOLERANCE": "where a search ends",
    "start_memory._LINEAR": "rounding of a control",
    "virtual_loop._JUST_LEFT": "where an event's time is rounded",
    "virtual_loop._AT_START": "rounding of a number of steps",
    "workshop._LEAVE_SECONDS": "how long a process is waited for",
    "workshop_process._LOOKS": "how often a process looks",
    "rosbag._NANOSECOND": "a unit",
    "twincat._FILETIME": "tells two units apart",
    "twincat._TICK": "a unit",
    "twincat._MILLISECOND": "a unit",
    "encoder_steps.STEP_SHARES": "the places of an encoder's steps that are tried",
    "clipping._ROUNDING": "rounding of floating point numbers",
    "jumps._TURN": "a whole turn",
    "own_period._NEAR": "how far a search goes",
    "own_period._FINE": "step of a search",
    "resampling._MOST_ROWS": "what there is memory for",
    "filtered_record._UNITS_APART": "factors of units that are told",
    "prefilter.DECIMATION_EDGE": "where the decimation filter ends",
    "sampled_filter._RIPPLE_DB": "of a filter's design",
    "without_turns._SMALLEST": "whose square is a number",
    "without_turns._ALIKE": "rounding of a column",
    "runaway._OFF": "step of a difference",
    "steps._SLACK": "rounding of a number of steps",
    "steps._UNIFORM": "how long a step is",
    "steps._ROUNDING": "rounding of a rate",
    "steps._PUSHES": "forces and none, by which a rate is told apart",
    "steps._DIRECTIONS": "sides of a motion, beside that at rest",
    "twin._MOST_SAMPLES": "what there is memory for",
    "propagation._STEP": "step of a difference",
    "variable_projection._SPREAD": "starts of a search",
    "known_spread._STEP": "step of a difference",
    "layout._SAME": "rounding of a column",
    "prefilters._FARTHER": "which of two decimations is taken",
    "windows._ROUNDING": "rounding of times",
    "told._ROUNDING": "of mean errors",
    "attenuation._SAME": "rounding of a column",
    "bias._SAME": "rounding of an eigenvalue",
    "base_distance._STILL": "where an iteration ends",
    "base_distance._SIZES": "starts of a search",
    "base_distance._STRETCHES": "starts of a search",
    "base_distance._SHARPEST": "rounding of a deviation",
    "filter_bias._STEP": "step of a difference",
    "pace._ROUNDING": "rounding of a value",
    "pace._SWINGING": "how an iteration is damped",
    "pace._NEAR": "how an iteration goes on",
    "pace._FALLING": "how an iteration goes on",
    "pace._LEAST": "how an iteration is damped",
    "alignment._STEP": "between the delays that are tried",
    "alignment._STILL": "where an iteration ends",
    "sentences._COLUMN_FAULTS": "factors of units that are tried",
    "sentences._UNITS": "factors of units that are told",
    "candidates._SPEEDS": "the terms that are tried",
    "candidates._LONGEST": "the terms that are tried",
    "candidates._ROWS_IN_A_WAVE": "the terms that are tried",
    "candidates._FINER": "step of a search",
    "candidates._FREQUENT": "where a series ends",
    "candidates._RARE": "whose logarithm is a number",
    "unit_labels._FACTORS": "units",
    "written._PROBED": "values that are tried",
    "written._WHOLE": "rounding of a count",
    "instruments._NOTHING": "rounding of a column",
    "instruments._NOTHING_LEFT": "rounding of what is left of a column",
    "slopes.STEP": "step of a difference",
    "slopes._ROOM": "rounding of a step",
    "slopes._SHORTER": "how a step is cut",
    "gains._NEXT_TO_0": "of a declared gain",
    "window_predictions._STEP": "step of a difference",
    "window_predictions._STILL": "where an iteration ends",
    "window_predictions._SHARES": "of a step, that are tried",
    "window_predictions._SHOWN": "rank of a triangle",
    "window_predictions._OTHER": "from which another start of an iteration is taken",
    "window_predictions._SHORTEST": "windows that are asked first",
    "law_moves._PERCENT": "a unit",
    "unknowns._SPREAD": "starts of a search",
    "fit._SETTLED": "where an iteration ends",
    "bounded._ROUNDING": "of sums",
    "robust._STANDS_STILL": "of an iteration",
    "robust._ROUNDING": "of sums",
    "search._TOLERANCE": "where a search ends",
    "search._NEAR": "what is asked exactly afterwards",
    "search._LOST": "what a lost lane counts as",
    "lag_products._LONGEST": "how far a search goes",
    "vector_autoregression._OWN": "a step of arithmetic",
    "start._SIZE": "step of a difference",
    "added_slopes.ADDED_SHARE": "step of a difference",
    "missing._HARDLY": "of what is beside it",
    "missing._FEWEST": "least freedom of a distribution",
    "motion_terms._SLOW": "a shape that is looked for",
    "motion_terms._SLOWER": "a shape that is looked for",
    "checks_of_parameters._SURE": "of a variance",
    "timing._FURTHEST": "how far a search goes",
    "timing._LEAST": "where a search starts",
    "starting._PART_OF_FORCE": "step of a difference",
    "unknowns._INSIDE": "starts of a search",
    "log_rows._FORGOTTEN": "rounding of what a filter keeps",
    "sweep._LOWEST": "the cut-offs that are tried",
    "sweep._HIGHEST": "the cut-offs that are tried",
    "recommendation._LEAST": "rounding of an error",
}
#: The same in comparisons, which no constant names.
COMPARED = {
    "compiler": "seconds that a clock knows",
    "base_distance": "where an iteration is given up",
    "in_time": "half a sample, between whole ones",
}
ROOT = Path(__file__).parents[3]
#: The rooms that hold records, fits and judgements: all of estimation but the table itself.
JUDGING = (
    "codegen/accuracy",
    "codegen/native",
    "codegen/runtime",
    *sorted(
        str(face.parent.relative_to(ROOT))
        for face in (ROOT / "estimation").rglob("__init__.py")
        if face.parent.name not in ("estimation", "thresholds")
    ),
)


def _constants(file: Path) -> dict[str, ast.expr]:
    """The constants of a module, by name."""
    found = {}
    for node in ast.parse(file.read_text()).body:
        if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            several = isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple)
            pairs = (
                zip(target.elts, node.value.elts, strict=True)
                if several
                else [(target, node.value)]
            )
            found |= {n.id: v for n, v in pairs if isinstance(n, ast.Name) and n.id.isupper()}
    return found


def _has_float(value: ast.expr) -> bool:
    return any(isinstance(n, ast.Constant) and type(n.value) is float for n in ast.walk(value))


def test_every_module_of_the_rooms_is_a_subject_of_the_page(root: Path) -> None:
    stages = ("codegen", "estimation")
    files = [file.stem for s in stages for file in (root / s / "thresholds").glob("*.py")]
    assert sorted({*files} - {"__init__", "threshold"}) == sorted(SUBJECTS)
    assert len(files) == len(SUBJECTS) + len(stages) + 1, "a name stands for one module"


def test_a_name_stands_for_one_row() -> None:
    names = [name for subject in SUBJECTS for name in rows_of(subject)]
    assert sorted(names) == sorted({*names})


@pytest.mark.slow
def test_every_row_is_used_somewhere() -> None:
    assert set(ROWS) - set(users()) == set()


def test_a_row_says_its_unit_its_meaning_and_its_source(root: Path) -> None:
    known = {*re.findall(r"@\w+\{(\w+),", (root / "docs" / "references.bib").read_text())}
    for name, row in ROWS.items():
        assert row.unit, name
        assert len(row.meaning) > 20, name
        assert not row.meaning.endswith("."), name
        cited = {*re.findall(r"\[(\w+)\]", row.source)}
        assert cited <= known, name
        said = re.match(r"(measured: .|derived: .|convention|chosen)", row.source)
        assert cited or said, name


def test_a_row_cannot_be_changed() -> None:
    with pytest.raises(AttributeError):
        Threshold(1.0, "1", "something", "chosen").value = 2.0  # type: ignore[misc]


@pytest.mark.parametrize("folder", JUDGING)
def test_a_room_that_judges_has_no_number_of_its_own(folder: str, root: Path) -> None:
    own = {
        f"{file.stem}.{name}"
        for file in (root / folder).glob("*.py")
        for name, value in _constants(file).items()
        if _has_float(value)
    }
    assert own - set(IMPLEMENTATION) == set()


@pytest.mark.parametrize("folder", JUDGING)
def test_a_room_that_judges_compares_with_no_number_of_its_own(folder: str, root: Path) -> None:
    own = {
        (file.stem, ast.unparse(node))
        for file in (root / folder).glob("*.py")
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.Compare) and any(map(_is_own, ast.walk(node)))
    }
    assert {each for each in own if each[0] not in COMPARED} == set()


def _is_own(node: ast.AST) -> bool:
    """A float, but for the ends of a share; or ten times something and more."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
        return any(
            isinstance(side, ast.Constant) and type(side.value) is int and side.value >= 10
            for side in (node.left, node.right)
        )
    value = node.value if isinstance(node, ast.Constant) else None
    return type(value) is float and value not in (0.0, 1.0)


@pytest.mark.slow
def test_every_exception_is_still_there(root: Path) -> None:
    there = {
        f"{file.stem}.{name}"
        for folder in JUDGING
        for file in (root / folder).glob("*.py")
        for name, value in _constants(file).items()
        if _has_float(value) or isinstance(value, ast.BinOp)
    }
    assert set(IMPLEMENTATION) - there == set()


@pytest.mark.slow
def test_the_page_prints_every_row_with_its_value_and_its_users() -> None:
    lines, used = page().splitlines(), users()
    for name, row in ROWS.items():
        (line,) = (line for line in lines if line.startswith(f"| `{name}` |"))
        assert line.split(" | ")[1:4] == [f"{row.value:g}", row.unit, row.meaning]
        assert all(f"`{module}`" in line for module in used[name]), name


def test_the_page_that_prints_the_table_is_listed(root: Path) -> None:
    assert "threshold_tables import page" in (root / "docs" / "thresholds.py").read_text()
    assert "\nthresholds\n" in (root / "docs" / "index.md").read_text()
    text = (root / "docs" / "thresholds.py").read_text()
    assert all(f"`{room}`" in text for room in ROOMS)
