"""Write the schema of results, `docs/schema/results-1.json`, from the classes that they are made of.

python docs/results_schema.py
"""

import json
from pathlib import Path

from axisid.presentation.result_files import results_schema

FILE = Path(__file__).resolve().parent / "schema" / "results-1.json"


def schema_text() -> str:
    """The schema as its file has it."""
    return json.dumps(results_schema(), indent=2) + "\n"


def main() -> None:
    """Write the file, and leave it alone if it is current."""
    text = schema_text()
    if FILE.read_text(encoding="utf-8") != text:
        FILE.write_text(text, encoding="utf-8")
        print(f"wrote {FILE.name}")


if __name__ == "__main__":
    main()
