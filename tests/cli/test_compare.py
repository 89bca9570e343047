"""``skinviz compare``: a folder or an archive to tables, figures and a report."""

import csv
import json
import shutil

import numpy as np
import pytest
from PIL import Image

from skinviz.cli.main import main

EXAMPLE = "docs/examples/study"
TABLES = {
    *("report.md", "means.csv", "differences.csv", "colours.csv", "levels.csv"),
    *("spectra.csv", "gaps.csv", "comparison.json"),
}
FIGURES = {"spectra", "weights", "colours"}


def run(capsys, *words):
    """Run the verb; return its exit code, and what it said."""
    code = main(["compare", *map(str, words)])
    told = capsys.readouterr()
    return code, told.out, told.err


def rows_of(file):
    """Return the rows of a CSV file."""
    with file.open(encoding="utf-8") as text:
        return list(csv.DictReader(text))


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    """The example compared by condition, hands and all."""
    out = tmp_path_factory.mktemp("compared")
    assert main(["compare", EXAMPLE, "--by", "condition", "--out", str(out)]) == 0
    return out


def test_all_files_are_written(compared):
    figures = {f"{n}.{s}" for n in {*FIGURES, "hands"} for s in ("png", "svg")}
    assert {path.name for path in compared.iterdir()} == TABLES | figures


def test_the_tables_say_what_was_put_in(compared):
    """After sun there is more oxyhaemoglobin on the back of the hand alone."""
    rows = rows_of(compared / "differences.csv")
    by_site = {r["site"]: r for r in rows if r["quantity"] == "w_h"}
    hand, arm = by_site["back of hand"], by_site["inner arm"]
    assert float(hand["p_holm"]) < 0.05 < float(arm["p_holm"])
    assert float(hand["lower"]) > 0
    assert (hand["test"], hand["effect_name"]) == ("paired t", "Cohen d_z")
    assert (hand["n_first"], arm["n_second"]) == ("8", "7")
    means = rows_of(compared / "means.csv")
    assert {r["condition"] for r in means} == {"before", "after sun"}
    for row in means:
        assert float(row["lower"]) <= float(row["mean"]) <= float(row["upper"])


def test_spectra_are_means_with_their_spread(compared):
    rows = rows_of(compared / "spectra.csv")
    assert len(rows) == 4 * 31
    assert all(0 < float(row["mean"]) < 1 for row in rows)
    assert all(0 < float(row["standard_deviation"]) < 0.1 for row in rows)


def test_the_report_names_source_gaps_and_figures(compared):
    text = (compared / "report.md").read_text("utf-8")
    for words in (
        "computed by the two-layer model",
        "| missing | 1 | no record | H, inner arm, after sun |",
        "![Hands](hands.png)",
        "Cohen d_z",
        "## Differences, back of hand",
    ):
        assert words in text
    assert "None" not in text
    assert "nan" not in text


def test_hands_lie_side_by_side_and_differ_in_colour(compared):
    with Image.open(compared / "hands.png") as picture:
        pixels = np.asarray(picture.convert("RGB")).astype(int)
    half = pixels.shape[1] // 2
    skin = (pixels[..., 0] - pixels[..., 2] > 25) & (pixels[..., 0] > 90)
    left, right = skin[:, :half], skin[:, half:]
    assert abs(left.sum() / right.sum() - 1) < 0.05
    top = slice(0, pixels.shape[0] // 2)
    before = pixels[top, :half][left[top]].mean(axis=0)
    after = pixels[top, half:][right[top]].mean(axis=0)
    assert after[1] < before[1] - 2  # redder: less green


def test_json_is_what_the_file_holds(capsys, tmp_path):
    words = (EXAMPLE, "--by", "group", "--out", tmp_path, "--no-hands", "--json")
    code, said, _ = run(capsys, *words)
    told = json.loads(said)
    assert code == 0
    assert len(told.pop("files")) == len(TABLES) + 2 * len(FIGURES)
    assert json.loads((tmp_path / "comparison.json").read_text("utf-8")) == told
    assert told["levels"] == ["sunscreen", "none"]
    assert {row["test"] for row in told["differences"]} == {"Welch t"}


def test_the_same_seed_writes_the_same_numbers(capsys, tmp_path):
    for name in ("one", "two"):
        words = (EXAMPLE, "--by", "site", "--out", tmp_path / name, "--no-hands")
        assert run(capsys, *words)[0] == 0
    for name in (*TABLES, "spectra.svg"):
        one, two = ((tmp_path / n / name).read_bytes() for n in ("one", "two"))
        assert one == two


def test_strict_stops_and_writes_nothing(capsys, tmp_path):
    out = tmp_path / "out"
    words = (EXAMPLE, "--by", "site", "--out", out, "--strict")
    code, _, told = run(capsys, *words)
    assert code == 1
    assert "H, inner arm, after sun: no record" in told.splitlines()[-1]
    assert not out.exists()


def test_archives_are_compared_by_group(capsys, tmp_path):
    words = ("--archive", "issa", "--group", "Chinese", "--group", "South Asian")
    code, said, _ = run(
        capsys, *words, "--site", "cheek", "--by", "group", "-o", tmp_path, "--no-hands"
    )
    assert code == 0
    assert "differences tested" in said
    rows = rows_of(tmp_path / "differences.csv")
    assert {row["test"] for row in rows} == {"t within origins"}
    text = (tmp_path / "report.md").read_text("utf-8")
    assert "Lu et al." in text
    assert "CC BY 4.0" in text


def test_groups_of_other_laboratories_are_not_tested(capsys, tmp_path):
    words = ("--archive", "issa", "--group", "Chinese", "--group", "African")
    code, said, _ = run(
        capsys, *words, "--site", "cheek", "--by", "group", "-o", tmp_path, "--no-hands"
    )
    assert code == 0
    assert "0 of 0 differences tested" in said
    text = (tmp_path / "report.md").read_text("utf-8")
    assert "confounded: no origin has both" in text


def test_sites_that_table_i_lacks_can_be_likened(capsys, tmp_path):
    words = ("--archive", "issa", "--group", "Chinese", "--by", "site")
    code, said, _ = run(
        capsys,
        *(*words, "--site", "palm", "--site", "cheek", "--like", "palm=back of hand"),
        *("--out", tmp_path, "--no-hands"),
    )
    assert code == 0
    assert "palm" in said


def test_levels_can_be_chosen(capsys, tmp_path):
    words = ("--by", "subject", "--level", "A", "--level", "C", "--no-hands", "--json")
    code, said, _ = run(capsys, EXAMPLE, *words, "--out", tmp_path)
    assert code == 0
    assert json.loads(said)["levels"] == ["A", "C"]


def test_a_hand_that_cannot_be_read_is_replaced_and_told(capsys, tmp_path):
    study = tmp_path / "study"
    shutil.copytree(EXAMPLE, study)
    (study / "broken.ply").write_text("ply\n", "utf-8")
    toml = study / "study.toml"
    text = toml.read_text("utf-8")
    own = "../../../meshes/makehuman_male_right.ply"
    toml.write_text(text.replace(own, "broken.ply"), "utf-8")
    (study / "gonio" / "A.csv").write_text("x\n", "utf-8")
    words = ("--by", "subject", "--level", "A", "--level", "B", "-o", tmp_path / "out")
    code, said, _ = run(capsys, study, *words)
    assert code == 0
    assert "note: the hand of A is not used" in said
    assert "note: the readings of A are not used" in said


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--by", "site"), "name one: the folder of a study, or --archive"),
        ((EXAMPLE, "--by", "site", "--archive", "issa"), "name one"),
        ((EXAMPLE, "--by", "colour"), "unknown factor to compare by 'colour'"),
        ((EXAMPLE, "--by", "site", "--group", "x"), "--group is for an --archive"),
        ((EXAMPLE, "--by", "site", "--like", "a=b"), "--like is for an --archive"),
        ((EXAMPLE, "--by", "site", "--illuminant", "D99"), "D99"),
        ((EXAMPLE, "--by", "site", "--model", "none"), "unknown skin model"),
        ((EXAMPLE, "--by", "site", "--seed", "-1"), "seed"),
        (("none", "--by", "site"), "no such file"),
        (("--archive", "issa", "--by", "site", "--like", "palm"), "takes SITE=SITE"),
        (("--archive", "nist", "--by", "site"), "there is 'inner arm' alone"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line(capsys, tmp_path, words, told):
    out = tmp_path / "out"
    code, _, said = run(capsys, *words, "--out", out)
    assert code == 1
    assert told in said.splitlines()[-1]
    assert not out.exists()


def test_a_file_is_no_folder_to_write_into(capsys, tmp_path):
    file = tmp_path / "out"
    file.write_text("x", "utf-8")
    code, _, told = run(capsys, EXAMPLE, "--by", "site", "--out", file)
    assert code == 1
    assert "is a file; name a folder" in told
