"""``skinviz archive``: lists, tables, filters, files, import, refusals."""

import json

import pytest
from spreadsheets import HEADINGS, WAVELENGTHS, cells, write_book

from skinviz import load_archive, read_spectra
from skinviz.cli.main import main


@pytest.fixture
def book(tmp_path):
    """A spreadsheet of ten records."""
    ten = load_archive("issa").isel(record=range(10))
    rows = [[*HEADINGS, *WAVELENGTHS], *cells(ten)]
    return write_book(tmp_path / "full.xlsx", ("ISSA", rows))


def run(capsys, *words):
    """Run a verb; return its exit code, and what it said."""
    code = main(["archive", *map(str, words)])
    told = capsys.readouterr()
    return code, told.out, told.err


def test_without_a_name_the_archives_are_listed_with_their_sources(capsys):
    code, said, _ = run(capsys)
    assert code == 0
    for fact in ("issa", "nist", "CC BY 4.0", "public domain", "specular included"):
        assert fact in said
    code, said, _ = run(capsys, "--json")
    listed = {facts["archive"]: facts for facts in json.loads(said)}
    assert listed["issa"]["spectra"] == 8307
    assert listed["nist"]["people"] == 100


def test_a_name_shows_groups_by_sites(capsys):
    code, said, _ = run(capsys, "issa")
    assert code == 0
    lines = {line.split("  ")[0]: line.split() for line in said.splitlines()}
    assert lines["ring finger"][-5:] == ["9/9", "-", "-", "-", "116/116"]
    assert lines["all"][1:] == [
        "941/146", "2512/352", "2123/254", "1326/149", "1405/157",
    ]  # fmt: skip
    for fact in ("114: the same under", "1424 spectra of 711", "Iraq/493, Iraq/494"):
        assert fact in said


def test_filters_narrow_the_counts(capsys):
    words = ["issa", "--site", "palm", "--origin", "China", "--sex", "F", "--json"]
    code, said, _ = run(capsys, *words)
    facts = json.loads(said)
    assert code == 0
    assert list(facts["table"]) == ["palm"]
    assert list(facts["origin"]) == ["China"]
    assert list(facts["sex"]) == ["F"]
    assert facts["spectra"] == facts["sex"]["F"]["spectra"] > 50
    code, said, _ = run(capsys, "issa", "--subject", "186", "--json")
    assert json.loads(said)["people"] == 1
    code, said, _ = run(capsys, "issa", "--average", "--json")
    assert json.loads(said)["spectra"] == 7488


def test_chosen_spectra_are_written_for_fit(tmp_path, capsys):
    out = tmp_path / "hands.csv"
    words = ["--site", "back of hand", "--group", "African", "-o", out]
    code, said, _ = run(capsys, "issa", *words)
    assert code == 0
    assert str(out) in said
    assert "left out     360, 370, 380, 390, 710, 720, 730, 740 nm" in said
    spectra = read_spectra(out)
    assert spectra.reflectance.shape == (74, 31)
    assert spectra.attrs["specular"] == "included"
    assert main(["fit", str(out), "--site", "back of hand", "--json"]) == 0
    fits = json.loads(capsys.readouterr().out)["fits"]
    assert fits[0]["label"].startswith("UK3/")


def test_import_writes_an_archive_that_the_verb_reads(book, tmp_path, capsys):
    out = tmp_path / "full.nc"
    code, said, told = run(capsys, "import", book, "-o", out)
    assert code == 0
    assert "[2/4] read ISSA" in told
    assert "10 spectra, 2 people, 9 sites" in said
    assert str(out) in said
    code, said, _ = run(capsys, out, "--site", "palm", "--json")
    assert code == 0
    assert json.loads(said)["spectra"] == 1
    code, said, _ = run(capsys, "import", book, "-o", out, "--json")
    assert json.loads(said)["files"] == [str(out)]


def test_import_takes_a_column_by_its_letter(book, tmp_path, capsys):
    out = tmp_path / "full.nc"
    words = ["import", book, "-o", out, "--column", "group=C", "--column", "sex=sex"]
    assert run(capsys, *words)[0] == 0
    assert set(load_archive(out).group.values) == {"Caucasian"}


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["tm30"], "unknown archive 'tm30'; choose one of: issa, nist; or name a .nc"),
        (["no.nc"], "no.nc: no such file"),
        (
            ["issa", "--site", "hand"],
            "unknown site 'hand'; choose one of: back of hand",
        ),
        (["--site", "palm"], "name an archive to choose from"),
        (["issa", "-o", "x.doc"], "x.doc"),
        (["import", "no.xlsx", "-o", "x.nc"], "no.xlsx: no such file"),
        (["import", "no.xlsx", "-o", "x.csv"], "choose one of: .nc"),
        (["import", "no.xlsx", "-o", "x.nc", "--column", "site"], "LABEL=HEADING"),
        (["import", "no.xlsx", "-o", "x.nc", "--scale", "%"], "unknown scale '%'"),
    ],
)
def test_an_error_is_one_line_and_ends_with_1(words, expected, capsys):
    code, said, told = run(capsys, *words)
    assert code == 1
    assert expected in told.strip().splitlines()[-1]
    assert not said


def test_a_refused_import_writes_nothing(book, tmp_path, capsys):
    out = tmp_path / "full.nc"
    code, _, told = run(capsys, "import", book, "-o", out, "--scale", "percent")
    assert code == 1
    assert "say --scale fraction" in told
    assert [path.name for path in tmp_path.iterdir()] == ["full.xlsx"]


@pytest.mark.parametrize("words", [["issa", "x"], ["import", "x.xlsx"], ["--nonsense"]])
def test_wrong_usage_ends_with_2(words, capsys):
    assert run(capsys, *words)[0] == 2


def test_import_has_help_with_an_example(capsys):
    code, said, _ = run(capsys, "import", "--help")
    assert code == 0
    assert "Example: skinviz archive import" in said
    assert "--json" in said
