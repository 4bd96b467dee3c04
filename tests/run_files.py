"""What is said of a log, as a run.toml beside it."""

import json
from pathlib import Path


def run_file(log: Path, name: str = "run.toml", **said: object) -> Path:
    """Write what is said of a log beside it."""
    lines = [f"log = {json.dumps(log.name)}", *(f"{key} = {_toml(v)}" for key, v in said.items())]
    file = log.parent / name
    file.write_text("\n".join(lines))
    return file


def _toml(value: object) -> str:
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{json.dumps(k)} = {_toml(v)}' for k, v in value.items())} }}"
    return json.dumps(value)
