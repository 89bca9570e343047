"""Write the shipped coefficient tables from their formulas.

``python scripts/make_coefficients.py`` after a change of ``effective.toml``; a test
proves that the tables in the package are what this writes.
"""

from pathlib import Path

from skinviz._files import whole_file
from skinviz.skin.formulas import (
    effective_coefficients,
    effective_numbers,
    table_text,
    textbook_coefficients,
)

DATA = Path(__file__).parents[1] / "skinviz" / "skin" / "data"


def main() -> None:
    """Write both tables."""
    for table in (effective_coefficients(effective_numbers()), textbook_coefficients()):
        with whole_file(DATA / f"{table.name}.csv") as partial:
            partial.write_text(table_text(table), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
