"""Speed against accuracy on the demo hand: ``python scripts/tradeoff_page.py``.

Writes ``docs/tradeoff.md``, and ``docs/images/tradeoff.png`` and
``docs/tables/tradeoff.csv``, which are what ``skinviz tradeoff`` gives for
``docs/examples/scene.toml``. Let nothing else run meanwhile. The folder of a run that
was made before may be named: then nothing is measured.
"""

import csv
import shutil
import sys
import tempfile
from pathlib import Path

from skinviz._files import whole_file
from skinviz.cli.main import main as skinviz

DOCS = Path(__file__).parents[1] / "docs"
PAGE = Path(__file__).with_name("tradeoff_page.md")
SIZE = "512"
Row = dict[str, str]


def read(file: Path) -> tuple[dict[str, str], list[Row]]:
    """Return what the table's head says, and its rows."""
    lines = file.read_text("utf-8").splitlines()
    head = [line[2:] for line in lines if line.startswith("# ")]
    told = dict(line.split(": ", 1) for line in head)
    return told, list(csv.DictReader(lines[len(head) :]))


def number(row: Row, name: str) -> float:
    """Return one of a row's numbers."""
    return float(row[name])


def as_markdown(rows: list[list[str]]) -> str:
    """Return rows as a Markdown table."""
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join([lines[0], "|---" * len(rows[0]) + "|", *lines[1:]])


def measured(rows: list[Row]) -> str:
    """Return the table of ways, those of knobs and grids left to the CSV."""
    table = [["way", "ms", "planning, ms", "99 %", "maximum", "edges, 99 %", "spectra"]]
    for row in rows:
        if row["group"] in ("one knob", "grid"):
            continue
        planned = row["group"] == "tolerance"
        table.append(
            [
                f"plan for {row['name']}" if planned else label(row),
                f"{number(row, 'ms'):.0f}",
                f"{number(row, 'planning_ms'):.0f}" if planned else "",
                f"{number(row, 'delta_e_99_filled'):.3f}",
                f"{number(row, 'delta_e_max_filled'):.2f}",
                f"{number(row, 'delta_e_99_edge'):.2f}",
                f"{number(row, 'spectral_rmse'):.1e}",
            ]
        )
    return as_markdown(table)


def label(row: Row) -> str:
    """Return what a way is called that was not planned."""
    name = {"reference": "the reference", "plain": "the plain way"}
    return name.get(row["group"], row["name"])


def chosen(rows: list[Row]) -> str:
    """Return what the plans chose."""
    reference = rows[0]
    names = ("samples", "refine", "shadows", "specular", "shading", "spectrum")
    table = [["tolerance", *names, "front", "kept"]]
    for row in rows:
        if row["group"] == "tolerance":
            settings = [row[name] or "-" for name in names]
            told = [
                f"**{value}**" if value != (reference[name] or "-") else value
                for name, value in zip(names, settings, strict=True)
            ]
            yes = [
                "yes" if row[key] == "True" else "no" for key in ("on_front", "kept")
            ]
            table.append([row["tolerance"], *told, *yes])
    return as_markdown(table)


def page(head: dict[str, str], rows: list[Row]) -> str:
    """Return the page."""
    reference = rows[0]
    plain = next(row for row in rows if row["group"] == "plain")
    one = next(row for row in rows if row["tolerance"] == "1.0")
    ms, planning = number(one, "ms"), number(one, "planning_ms")
    return PAGE.read_text("utf-8").format(
        **head,
        size=SIZE,
        measured=measured(rows),
        chosen=chosen(rows),
        faster=number(reference, "ms") / ms,
        faster_than_plain=number(plain, "ms") / ms,
        with_planning=number(reference, "ms") / (ms + planning),
        plain_with_planning=number(plain, "ms") / (ms + planning),
    )


def main(folder: Path, docs: Path = DOCS) -> None:
    """Write the page, its figure and its table from what a folder holds."""
    head, rows = read(folder / "tradeoff.csv")
    for name, kind in (("tradeoff.png", "images"), ("tradeoff.csv", "tables")):
        with whole_file(docs / kind / name) as partial:
            shutil.copyfile(folder / name, partial)
    with whole_file(docs / "tradeoff.md") as partial:
        partial.write_text(page(head, rows), encoding="utf-8")
    print(docs / "tradeoff.md")


if __name__ == "__main__":
    if len(sys.argv) > 2:
        sys.exit("usage: tradeoff_page.py [FOLDER]")
    if len(sys.argv) == 2:
        main(Path(sys.argv[1]))
        sys.exit()
    with tempfile.TemporaryDirectory() as made:
        scene = str(DOCS / "examples" / "scene.toml")
        if code := skinviz(["tradeoff", scene, "-o", made, "--size", SIZE]):
            sys.exit(code)
        main(Path(made))
