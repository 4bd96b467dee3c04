"""Packages, disk and links agree; the files speak of the software alone."""

import re
import subprocess
import tomllib
from pathlib import Path

import axisid


def test_packages_links_and_folders_agree(root: Path) -> None:
    tool = tomllib.loads((root / "pyproject.toml").read_text())["tool"]["setuptools"]
    on_disk = {"axisid"}
    for stage in ("modeling", "codegen", "estimation"):
        link = root / "src" / "axisid" / stage
        assert link.resolve() == (root / stage).resolve()
        assert tool["package-dir"][f"axisid.{stage}"] == stage
        for init in (root / stage).rglob("__init__.py"):
            parts = init.parent.relative_to(root).parts
            on_disk.add(".".join(("axisid", *parts)))
    own = root / "src" / "axisid"
    for init in own.rglob("__init__.py"):
        parts = init.parent.relative_to(own).parts
        if parts and parts[0] not in ("modeling", "codegen", "estimation"):
            on_disk.add(".".join(("axisid", *parts)))
    assert set(tool["packages"]) == on_disk


def test_files_of_data_are_in_the_wheel(root: Path) -> None:
    tool = tomllib.loads((root / "pyproject.toml").read_text())["tool"]["setuptools"]
    folders = [root / name for name in ("modeling", "codegen", "estimation", "src/axisid")]
    for file in (file for folder in folders for file in folder.rglob("*") if file.is_file()):
        if file.suffix in (".py", ".pyc"):
            continue
        inside = file.relative_to(root)
        inside = inside.relative_to("src/axisid") if inside.parts[0] == "src" else inside
        names = {above: ".".join(("axisid", *above.parts)) for above in inside.parents}
        package = next(above for above in inside.parents if names[above] in tool["packages"])
        patterns = tool["package-data"].get(names[package], [])
        assert any(inside.relative_to(package).match(pattern) for pattern in patterns), inside


def test_version_is_one(root: Path) -> None:
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    assert project["version"] == axisid.__version__
    assert f"version: {axisid.__version__}" in (root / "CITATION.cff").read_text()
    assert f"## {axisid.__version__}" in (root / "CHANGELOG.md").read_text()


def test_requirements_cover_what_the_project_declares(root: Path) -> None:
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    names, tests, docs = (
        [re.split(r"[<>=]", line)[0] for line in lines]
        for lines in (project["dependencies"], extras["test"], extras["docs"])
    )
    for file, needed in (
        ("run.txt", names),
        ("lowest.txt", names),
        ("test.txt", names + tests),
        ("docs.txt", names + docs),
    ):
        text = (root / "requirements" / file).read_text()
        for name in needed:
            assert re.search(rf"^{name}==", text, re.MULTILINE), f"{name} in {file}"
    lowest = (root / "requirements" / "lowest.txt").read_text()
    for name, bound in (line.split(">=") for line in project["dependencies"]):
        assert re.search(rf"^{name}=={re.escape(bound)}[.0-9]* ", lowest, re.MULTILINE), name


def test_no_tracked_file_names_a_machine_path(root: Path) -> None:
    listed = subprocess.run(
        ["git", "ls-files"], cwd=root, capture_output=True, text=True, check=False
    )
    for name in listed.stdout.split():
        file = root / name
        if file.is_file() and not file.is_symlink() and file.suffix != ".png":
            found = re.search(r"(?<![\w.])/(home|root|work|tmp)/\w", file.read_text())
            assert found is None, f"{name}: {found}"


def test_every_reference_in_a_docstring_is_in_the_bibliography(root: Path) -> None:
    known = set(re.findall(r"@\w+\{(\w+),", (root / "docs" / "references.bib").read_text()))
    for stage in ("modeling", "codegen", "estimation", "src/axisid"):
        for file in (root / stage).glob("**/*.py"):
            cited = set(re.findall(r"\[([A-Z]\w+\d{4})\]_", file.read_text()))
            assert cited <= known, file
