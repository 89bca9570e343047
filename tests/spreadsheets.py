"""Spreadsheets of archives, written for tests."""

import numpy as np
import openpyxl

HEADINGS = ("record", "origin", "subject", "group", "sex", "age_group", "site")
WAVELENGTHS = [f"{nm}" for nm in range(360, 741, 10)]


def cells(archive, scale=1.0):
    """Return each record as the cells of a row, empty where not measured."""
    labels = [archive[name].values for name in HEADINGS]
    for i, spectrum in enumerate(archive.reflectance.values):
        own = [column[i] for column in labels]
        yield [
            int(own[0]),
            *(text or None for text in own[1:]),
            *(None if np.isnan(r) else float(r * scale) for r in spectrum),
        ]


def write_book(path, *sheets):
    """Write sheets given as (name, rows) to a spreadsheet."""
    book = openpyxl.Workbook(write_only=True)
    for name, rows in sheets:
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path
