"""The publisher's spreadsheet: round trip from the shipped part, and broken ones."""

import zipfile

import numpy as np
import openpyxl
import pytest
import xarray
from numpy.testing import assert_allclose, assert_array_equal
from spreadsheets import HEADINGS, WAVELENGTHS, cells, write_book

from skinviz import ArgumentError, DataError, load_archive
from skinviz.spectra.archive_data import LABELS
from skinviz.spectra.archive_file import write_archive
from skinviz.spectra.issa_import import import_archive


@pytest.fixture(scope="module")
def issa():
    return load_archive("issa")


@pytest.fixture
def few(issa):
    """Three records of two people, one measured at 400-700 nm only."""
    return issa.isel(record=[0, 1, 8306])


@pytest.fixture
def book(tmp_path, few):
    """Return a function that writes the few records with some cells replaced."""

    def write(replaced=None, headings=(*HEADINGS, *WAVELENGTHS), head=()):
        rows = [*head, list(headings), *cells(few)]
        for (row, column), value in (replaced or {}).items():
            rows[row - 1][column] = value
        return write_book(tmp_path / "full.xlsx", ("ISSA", rows))

    return write


def assert_same_archive(found, expected):
    """Compare everything but the attributes, which name the file."""
    xarray.testing.assert_equal(found, expected)
    for key in ("licence", "specular", "geometry"):
        assert found.attrs[key] == expected.attrs[key]


def test_the_whole_shipped_part_survives_export_import_and_netcdf(issa, tmp_path):
    rows = [[*HEADINGS, *(int(nm) for nm in WAVELENGTHS)], *cells(issa)]
    path = write_book(tmp_path / "full.xlsx", ("coding", [["code"]]), ("ISSA", rows))
    steps = []
    found = import_archive(path, progress=steps.append)
    assert_same_archive(found, issa)
    assert found.attrs["unnamed_codes"] == ""
    assert "full.xlsx, SHA-256" in found.attrs["source"]
    assert steps == ["find the columns", "read ISSA", "check"]
    file = write_archive(tmp_path / "full.nc", found)
    assert_same_archive(load_archive(file), issa)
    assert load_archive(str(file)).attrs == found.attrs
    assert file.stat().st_size < issa.reflectance.nbytes


def published(archive, sites, groups, extra=()):
    """Return rows as the publisher lays them out: codes, per cent, tables on top."""
    wavelengths = list(range(360, 781, 10))
    blank = [None] * 13
    yield ["The International Skin Spectra Archive"]
    yield [*blank, *wavelengths]
    for _ in range(4):  # colour-matching functions and D65
        yield [*blank, *np.linspace(0.1, 90, 43).tolist()]
    for _ in range(5):
        yield []
    yield [
        *("Record", "Data Origin", "Subject Number", "Ethnicity (code)", "GENDER"),
        *("Age_group", "Body  Location", "Instrument", "SPIN", "Start", "End", "Step"),
        *(None, *wavelengths, None, "X", "Y", "Z"),
    ]
    for row in cells(archive, 100.0):
        row[1] = 1 if row[1] == "UK" else 8
        row[3], row[6] = groups[row[3]], sites[row[6]]
        settings = ["SP", "SCI", 360, 740, 10, None]
        yield [*row[:7], *settings, *row[7:], *[None] * 5, 1.0, 2.0, 3.0]
    yield from extra


def test_codes_percent_and_tables_above_read_as_published(few, tmp_path):
    sites = {"forehead": 6, "nose tip": 9, "neck": 8}
    rows = published(few, sites, {"Caucasian": "CA", "African": "AF"})
    path = write_book(tmp_path / "full.xlsx", ("Coding", [["a"]]), ("ISSA", rows))
    found = import_archive(path, scale="percent")
    assert_allclose(found.reflectance, few.reflectance, rtol=1e-15)
    for label in LABELS:
        assert_array_equal(found[label], few[label])
    assert_array_equal(found.wavelength, few.wavelength)


def test_codes_that_the_shipped_part_lacks_are_kept_and_said(few, tmp_path):
    sites = {"forehead": 6, "nose tip": 9, "neck": 8}
    more = [15000, 4, 700, "TH", "F", None, 2, "SP", "SCI", 360, 740, 10, None]
    rows = published(
        few, sites, {"Caucasian": "CA", "African": "AF"}, [[*more, *[30.0] * 39]]
    )
    path = write_book(tmp_path / "full.xlsx", ("ISSA", rows))
    found = import_archive(path, scale="percent")
    assert found.group.values.tolist() == ["Caucasian", "Caucasian", "African", "TH"]
    assert found.site.values[-1] == "2"
    assert found.attrs["unnamed_codes"] == "origin 4; group TH; site 2"


def test_a_number_of_another_spectrum_names_no_code(few, tmp_path):
    other = few.assign(reflectance=few.reflectance * 0.9)
    sites = {"forehead": 6, "nose tip": 9, "neck": 8}
    rows = published(other, sites, {"Caucasian": "CA", "African": "AF"})
    path = write_book(tmp_path / "full.xlsx", ("ISSA", rows))
    assert import_archive(path, scale="percent").site.values.tolist() == ["6", "9", "8"]


@pytest.mark.parametrize("shape", ["{}", "{}nm", "{} nm", "R{}", "r_{}", "λ{}"])
def test_wavelengths_are_read_from_headings(shape, book, few):
    headings = (*HEADINGS, *(shape.format(nm) for nm in WAVELENGTHS))
    assert_same_archive(import_archive(book(headings=headings)), few)


def test_merged_headings_above_the_wavelengths_are_found(book, few):
    empty = (None,) * len(HEADINGS)
    path = book(headings=(*empty, *WAVELENGTHS), head=[["notes"], list(HEADINGS)])
    assert_same_archive(import_archive(path), few)


def test_sheets_with_the_same_wavelengths_are_joined(few, tmp_path):
    head = [[*HEADINGS, *WAVELENGTHS]]
    rows = list(cells(few))
    path = tmp_path / "full.xlsx"
    write_book(path, ("A", head + rows[:1]), ("B", head + rows[1:]))
    assert_same_archive(import_archive(path), few)
    short = [[*row[:-1]] for row in head + rows[1:]]
    write_book(path, ("A", head + rows[:1]), ("B", short))
    with pytest.raises(DataError, match="different wavelengths"):
        import_archive(path)


def test_a_column_of_another_name_can_be_given(book, few):
    headings = ("record", "origin", "subject", "group", "sex", "age", "spot")
    path = book(headings=(*headings, *WAVELENGTHS))
    with pytest.raises(
        DataError, match=r"no column for site; .*'spot'.*--column site="
    ):
        import_archive(path)
    for name in ("spot", "G", " Spot"):
        assert_same_archive(import_archive(path, columns={"site": name}), few)
    with pytest.raises(ArgumentError, match="unknown column 'place'"):
        import_archive(path, columns={"place": "G"})


def test_rows_without_labels_are_no_records(book, few):
    path = book(head=[])
    rows = [[*HEADINGS, *WAVELENGTHS], *cells(few), [], [None] * 7 + [0.5] * 39]
    write_book(path, ("ISSA", rows))
    assert_same_archive(import_archive(path), few)


BROKEN = {
    "text": ({(3, 9): "0,3"}, "row 3, column J: a number is due for 380 nm.*'0,3'"),
    "error": ({(2, 20): "#N/A"}, "row 2, column U: a number is due.*'#N/A'"),
    "true": ({(2, 20): True}, "row 2, column U: a number is due"),
    "gap": ({(2, 20): None}, "row 2, column U: empty at 490 nm, between measured"),
    "negative": ({(2, 20): -0.1}, "column U: -0.1 at 490 nm is not above 0"),
    "percent": ({(2, 20): 28.5}, "column U: 28.5 at 490 nm is above 1.5;.*--scale"),
    "nobody": ({(3, 2): None}, "row 3, column C: no subject"),
    "date": (
        {(3, 5): np.datetime64("2024-10-19").item()},
        "column F: age_group is datetime.*made it a date",
    ),
    "label error": ({(3, 6): "#REF!"}, "column G: site is the error '#REF!'"),
    "record text": ({(3, 0): "one"}, "record 'one' is no whole number"),
    "record twice": ({(3, 0): 1}, "record 1 is there more than once"),
}


@pytest.mark.parametrize(("replaced", "told"), BROKEN.values(), ids=BROKEN)
def test_a_bad_cell_is_refused_by_sheet_row_and_column(replaced, told, book):
    with pytest.raises(DataError, match=told) as caught:
        import_archive(book(replaced))
    assert "\n" not in str(caught.value)


def test_an_error_cell_and_a_formula_without_a_value_are_refused(few, tmp_path):
    path = tmp_path / "full.xlsx"
    rows = [[*HEADINGS, *WAVELENGTHS], *cells(few)]
    whole = openpyxl.Workbook()
    sheet = whole.active
    for row in rows:
        sheet.append(row)
    sheet["U2"] = "=NA()"  # openpyxl stores no value with a formula
    whole.save(path)
    with pytest.raises(DataError, match=r"column U: empty at 490 nm.*formula"):
        import_archive(path)
    for column in range(8, 47):
        sheet.cell(2, column).value = "=A1"
    whole.save(path)
    with pytest.raises(DataError, match=r"row 2.*no reflectance; a formula"):
        import_archive(path)


def test_a_record_without_the_surface_reflection_is_refused(few, tmp_path):
    rows = [[*HEADINGS, "SCI/SCE", *WAVELENGTHS]]
    rows += [[*row[:7], "SCE", *row[7:]] for row in cells(few)]
    path = write_book(tmp_path / "full.xlsx", ("ISSA", rows))
    with pytest.raises(DataError, match=r"row 2, column H: .*\(SCI\).*'SCE'"):
        import_archive(path)


def test_a_fraction_declared_as_per_cent_is_refused(book):
    with pytest.raises(DataError, match="say --scale fraction"):
        import_archive(book(), scale="percent")
    with pytest.raises(ArgumentError, match="unknown scale 'parts'"):
        import_archive(book(), scale="parts")


def test_a_sheet_without_wavelengths_or_records_is_refused(book, tmp_path):
    with pytest.raises(DataError, match=r"no sheet has a row of wavelengths.*ISSA"):
        import_archive(book(headings=(*HEADINGS, *["band"] * 39)))
    with pytest.raises(DataError, match="row 1: wavelengths must ascend; 730"):
        import_archive(book(headings=(*HEADINGS, *reversed(WAVELENGTHS))))
    empty = write_book(tmp_path / "head.xlsx", ("A", [[*HEADINGS, *WAVELENGTHS]]))
    with pytest.raises(DataError, match="headings and no records"):
        import_archive(empty)
    with pytest.raises(DataError, match="no sheet has a row of wavelengths"):
        import_archive(write_book(tmp_path / "blank.xlsx", ("A", [])))


def test_what_is_no_spreadsheet_is_refused(tmp_path, book):
    path = tmp_path / "bad.xlsx"
    with pytest.raises(DataError, match="no such file"):
        import_archive(path)
    path.write_bytes(b"")
    with pytest.raises(DataError, match="empty"):
        import_archive(path)
    path.write_bytes(b"record,origin\n1,UK\n")
    with pytest.raises(DataError, match=r"cannot be read as .xlsx"):
        import_archive(path)
    whole = book().read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(DataError, match=r"cannot be read as .xlsx"):
        import_archive(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", "no sheets here")
    with pytest.raises(DataError, match=r"cannot be read as .xlsx"):
        import_archive(path)


def rewritten(source, target, name, change):
    """Copy a zip file with one entry's bytes changed."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w", 8) as new:
        for entry in old.namelist():
            content = old.read(entry)
            new.writestr(entry, change(content) if entry == name else content)


def test_a_sheet_broken_in_the_middle_is_refused(issa, tmp_path):
    whole, path = tmp_path / "full.xlsx", tmp_path / "bad.xlsx"
    book = openpyxl.Workbook()  # says its size on top, as spreadsheet programs do
    book.active.title = "ISSA"
    for row in ([*HEADINGS, *WAVELENGTHS], *cells(issa.isel(record=slice(200)))):
        book.active.append(row)
    book.save(whole)
    sheet = "xl/worksheets/sheet1.xml"
    rewritten(whole, path, sheet, lambda xml: xml[: len(xml) * 2 // 3])
    with pytest.raises(DataError, match=r"sheet 'ISSA', row 1\d\d: broken"):
        import_archive(path)


def test_a_row_number_beyond_any_spreadsheet_ends_soon(book, tmp_path):
    path = tmp_path / "far.xlsx"
    sheet = "xl/worksheets/sheet1.xml"
    far = (b'<row r="4"', b'<row r="999999999999"')
    rewritten(book(), path, sheet, lambda xml: xml.replace(*far))
    with pytest.raises(DataError, match="more than 1048576 rows"):
        import_archive(path)


def test_a_spreadsheet_that_unpacks_to_an_absurd_size_is_refused(
    book, tmp_path, monkeypatch
):
    monkeypatch.setattr("skinviz.spectra.issa_import._MOST_BYTES", 10_000_000)
    path = tmp_path / "bomb.xlsx"
    book().rename(path)
    with zipfile.ZipFile(path, "a", 8) as archive:
        archive.writestr("xl/media/zeros", bytes(20_000_000))
    assert path.stat().st_size < 100_000
    with pytest.raises(DataError, match=r"unpacks to 0.02 GB"):
        import_archive(path)
