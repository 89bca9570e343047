"""Rebuild the shipped archives of measured skin from the tables they were cut from.

``python scripts/make_archives.py FOLDER [OUT]``, where FOLDER has the two tables by
the names in ``TABLES``, ISSA's plain or gzipped. Numbers are kept as they are
written; each table's shape is checked first. Checksums of everything in OUT (the
package's data) are written beside them.
"""

import csv
import gzip
import hashlib
import io
import sys
from pathlib import Path

DATA = Path(__file__).parents[1] / "skinviz" / "spectra" / "data"
ISSA = "issa_2025_part_360-740nm_10nm.csv.gz"
NIST = "nist_2017_inner_forearm_400-700nm_5nm.csv"
SUMS = "SHA256SUMS"
LABELS = ("record", "origin", "subject", "group", "sex", "age_group", "site")


def source_text(folder: Path, name: str) -> str:
    """Return a table's text, unpacked if it is gzipped."""
    plain = folder / name.removesuffix(".gz")
    content = plain.read_bytes() if plain.exists() else (folder / name).read_bytes()
    if content[:2] == b"\x1f\x8b":
        content = gzip.decompress(content)
    return content.decode("utf-8-sig")


def require(condition: bool, what: str) -> None:
    """Stop with one line if a table is not as published."""
    if not condition:
        sys.exit(f"make_archives: {what}")


def require_numbers(cells: list[str], where: str) -> None:
    """Stop unless every cell that is not empty is a reflectance between 0 and 1."""
    for cell in filter(None, cells):
        require(0 < float(cell) < 1, f"{where}: {cell} is no reflectance")


def checked_issa(rows: list[list[str]]) -> None:
    """Check the columns, the records and the numbers of ISSA's part."""
    header, *records = rows
    bands = [str(nm) for nm in range(360, 741, 10)]
    require(header == [*LABELS, *bands], "ISSA: the columns are others")
    require(len(records) == 8307, f"ISSA: {len(records)} records, not 8307")
    require(len({row[0] for row in records}) == 8307, "ISSA: a record is there twice")
    for row in records:
        require(len(row) == len(header), f"ISSA: record {row[0]} is cut off")
        require_numbers(row[len(LABELS) :], f"ISSA: record {row[0]}")


def checked_nist(rows: list[list[str]]) -> None:
    """Check the bands, the subjects and the numbers of NIST's forearms."""
    header, *bands = rows
    require(len(header) == 101, f"NIST: {len(header) - 1} subjects, not 100")
    nm = [float(row[0]) for row in bands]
    require(nm == [400.0 + 5 * i for i in range(61)], "NIST: the bands are others")
    for row in bands:
        require(len(row) == 101 and all(row), f"NIST: {row[0]} nm is cut off")
        require_numbers(row[1:], f"NIST: {row[0]} nm")


TABLES = {ISSA: checked_issa, NIST: checked_nist}


def compact(text: str, name: str) -> bytes:
    """Return a table's bytes as shipped; the same for the same zlib."""
    table = io.StringIO()
    csv.writer(table, lineterminator="\n").writerows(csv.reader(io.StringIO(text)))
    content = table.getvalue().encode()
    return gzip.compress(content, 9, mtime=0) if name.endswith(".gz") else content


def unpacked(path: Path) -> bytes:
    """Return a shipped table's bytes before packing, none if it is not there."""
    if not path.exists():
        return b""
    content = path.read_bytes()
    return gzip.decompress(content) if path.suffix == ".gz" else content


def main(source: Path, out: Path = DATA) -> None:
    """Write both tables where their content has changed, and all checksums."""
    for name, check in TABLES.items():
        text = source_text(source, name)
        check(list(csv.reader(io.StringIO(text))))
        content = compact(text, name)
        plain = gzip.decompress(content) if name.endswith(".gz") else content
        if unpacked(out / name) == plain:
            print(f"{name}: as it was")  # another zlib packs the same otherwise
        else:
            (out / name).write_bytes(content)
            print(f"{name}: written")
    lines = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n"
        for path in sorted(out.iterdir())
        if ".csv" in path.suffixes
    ]
    (out / SUMS).write_text("".join(lines), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: make_archives.py FOLDER [OUT]")
    main(*(Path(word) for word in sys.argv[1:]))
