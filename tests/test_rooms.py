"""The house: rooms on floors, every arrow down, no circle, also through late and typing imports."""

import ast
from collections import Counter
from graphlib import CycleError, TopologicalSorter
from itertools import chain, pairwise
from pathlib import Path

import pytest

from tests.rooms import FACES, Import, graph_of, imports_of, modules_of, room_of

#: Every room, from the ground up: a module imports of its own room and of rooms above it in this
#: list. Rooms of one line know nothing of each other.
FLOORS = (
    ("support",),
    ("modeling.quantities",),
    ("modeling.declaration",),
    ("elements", "control"),
    ("modeling.derivation", "modeling.library"),
    ("modeling.parsing",),
    ("codegen.lowering",),
    ("codegen.printers",),
    ("codegen.runtime",),
    ("codegen.generated_axes",),
    ("estimation.thresholds", "estimation.choices", "estimation.findings"),
    ("estimation.verdict_checks",),
    ("estimation.raw_tables",),
    ("estimation.logs.text",),
    ("estimation.logs",),
    ("estimation.records.columns",),
    ("estimation.records",),
    ("estimation.signals",),
    ("estimation.simulation",),
    ("estimation.law_replay",),
    ("estimation.regression",),
    ("estimation.unknowns",),
    ("estimation.estimation_problem",),
    ("estimation.noise_models",),
    ("estimation.estimates",),
    ("estimation.methods",),
    ("estimation.misspecification",),
    ("estimation.diagnostics.control_law",),
    ("estimation.diagnostics",),
    ("estimation.control_law_search",),
    ("estimation.identification",),
    ("estimation.batched",),
    ("estimation.output_residuals",),
    ("estimation.nonlinear_least_squares",),
    ("estimation.output_error",),
    ("estimation.model_selection", "estimation.model_validation"),
    ("estimation.monte_carlo",),
    ("presentation.sentences",),
    ("presentation.documents",),
    ("presentation.result_files",),
    ("presentation.plots",),
    ("presentation.text",),
    ("presentation",),
    ("export_targets",),
    ("exports",),
    ("fleets",),
    ("twins", "candidates"),
    ("paper",),
    ("commands.options",),
    ("commands",),
)
#: Rooms without a face: their modules are imported by name, so that nothing unused is loaded.
BY_NAME = (
    "support",
    "presentation",
    "commands",
)
#: Folders of tests that are no room's: the whole, results and texts that are kept, what goes wrong,
#: and what tests are made of.
NO_ROOMS = ("axes", "axisid", "benchmarks", "faults", "fuzz", "golden", "integration", "strategies")
#: Rooms without tests of their own, and where they are tested.
TESTED_ELSEWHERE = {
    "elements": "modeling.declaration",
    "control": "modeling.declaration",
    "export_targets": "exports",
    "estimation.findings": "estimation.verdict_checks",
}


@pytest.fixture(scope="module")
def modules(root: Path) -> dict[str, Path]:
    return modules_of(root)


@pytest.fixture(scope="module")
def imports(modules: dict[str, Path]) -> list[Import]:
    return [*imports_of(modules)]


def test_every_room_stands_on_a_floor_and_says_what_it_takes_gives_and_does_not_know(
    modules: dict[str, Path],
) -> None:
    rooms = {room_of(name, modules) for name in modules} - {"__main__"}
    assert rooms == {room for floor in FLOORS for room in floor} | {*FACES}
    for room in sorted(rooms - {*FACES}):
        said = ast.get_docstring(ast.parse(modules[room].read_text())) or ""
        assert {"In:", "Out:"} <= {*said.split()}, room
        assert "Knows nothing of " in " ".join(said.split()), room


def test_the_drawing_in_contributing_has_every_room_on_its_floor(root: Path) -> None:
    """A line's rooms are above all rooms of the lines below it."""
    text = (root / "CONTRIBUTING.md").read_text().partition("```\n")[2].partition("```")[0]
    drawn = []
    for line in text.splitlines():
        above, _, rooms = line.partition("|")[0].partition(":")
        drawn.append([f"{above}.{room}".strip(".") for room in rooms.split()])
    floor = {room: i for i, rooms in enumerate(FLOORS) for room in rooms}
    assert sorted(chain(*drawn)) == sorted(floor)
    levels = [[floor[room] for room in rooms] for rooms in drawn]
    assert all(min(upper) > max(lower) for upper, lower in pairwise(levels))


def test_tests_mirror_the_rooms(root: Path) -> None:
    """Every room has a folder with tests in it, and every folder is a room's."""
    tests = root / "tests"
    folders = {
        ".".join(file.parent.relative_to(tests).parts)
        for file in tests.rglob("test_*.py")
        if file.parent != tests
    }
    mirrored = {folder for folder in folders if folder.partition(".")[0] not in NO_ROOMS}
    rooms = {room for floor in FLOORS for room in floor}
    assert mirrored == rooms - TESTED_ELSEWHERE.keys()
    assert set(TESTED_ELSEWHERE.values()) <= mirrored


@pytest.mark.slow
def test_every_import_points_down_also_late_and_typing_only_ones(
    modules: dict[str, Path], imports: list[Import]
) -> None:
    floor = {room: i for i, rooms in enumerate(FLOORS) for room in rooms}
    wrong = []
    for module, line, _, source, name, own in imports:
        target = f"{source}.{name}" if f"{source}.{name}" in modules else source
        here, there = (room_of(m, modules) if m in modules else "" for m in (module, target))
        if not own or here == there or module in ("__main__", *FACES):
            continue
        if there in FACES or floor[there] >= floor[here]:
            wrong.append(f"{module}:{line} imports {name or source} of {there or 'axisid'}")
    assert wrong == []


@pytest.mark.slow
def test_no_modules_import_each_other_in_a_circle(modules: dict[str, Path]) -> None:
    assert _circle(graph_of(modules)) == []


def _circle(graph: dict[str, set[str]]) -> list[str]:
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_a_circle_is_found() -> None:
    assert set(_circle({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}})) == {"a", "b", "c"}


@pytest.mark.slow
def test_no_two_classes_have_one_name(modules: dict[str, Path]) -> None:
    trees = (ast.parse(file.read_text()) for file in modules.values())
    nodes = (node for tree in trees for node in ast.walk(tree))
    times = Counter(node.name for node in nodes if isinstance(node, ast.ClassDef))
    assert not {name for name, count in times.items() if count > 1}


def test_imports_are_relative_within_a_room_and_from_the_face_of_another(
    modules: dict[str, Path], imports: list[Import]
) -> None:
    wrong = []
    for module, line, level, source, name, own in imports:
        if own and name and modules[module].name != "__init__.py" and module != "__main__":
            there = room_of(source, modules) if source in modules else source
            to_face = source == there or there in BY_NAME
            if level > 1 or (level == 0 and (there == room_of(module, modules) or not to_face)):
                wrong.append(f"{module}:{line}")
    assert wrong == []


def test_rooms_know_no_library_that_is_not_theirs(imports: list[Import]) -> None:
    banned = {
        "estimation": {"sympy", "casadi", "matplotlib", "click"},
        "modeling": {"numpy", "scipy", "casadi", "matplotlib", "click"},
        "codegen.runtime": {"sympy", "matplotlib", "click"},
        **{
            f"presentation.{room}": {"matplotlib", "click", "rich"}
            for room in (
                "documents",
                "plots",
                "result_files",
                "text",
            )
        },
    }
    for module, line, _, source, name, own in imports:
        above = [room for room in banned if f"{module}.".startswith(f"{room}.")]
        used = source.partition(".")[0]
        is_type = (source, name) == ("matplotlib.figure", "Figure")
        assert own or is_type or not any(used in banned[r] for r in above), f"{module}:{line}"


def test_modules_are_imported_by_text_in_few_places(modules: dict[str, Path]) -> None:
    """They are no arrows that a test sees: a view, a format's library, an axis, rows of tables."""
    calls = ("import_module(", "resolve_name(", "lazy_loader.attach(")
    found = {n for n, file in modules.items() if any(c in file.read_text() for c in calls)}
    stub = {"commands.options.stages"}  # whose arrows the stub beside it has
    rows = {"export_targets", "estimation.methods.methods", "estimation.estimates.estimated_values"}
    assert found == {"support.presentable", "support.libraries", "modeling.library"} | stub | rows
