"""A study's folder: its ways of listing records, and what of it is missing and why."""

import numpy as np
import pytest
from benches import bench, human, run_session
from numpy.testing import assert_allclose, assert_array_equal
from study_folders import BANDS, skin, write_table

from skinviz import DataError, read_session, read_study
from skinviz.instruments.plan import Plan


def gaps_of(study):
    """Return what, whose and why of each gap."""
    return [(g.what, g.subject, g.site, g.condition, g.why) for g in study.gaps]


def listed(tmp_path, rows, head='title = "t"\nspecular = "included"\n'):
    """Write a study with a table of records."""
    (tmp_path / "records.csv").write_text("\n".join(rows) + "\n", "utf-8")
    (tmp_path / "study.toml").write_text(f'{head}records = "records.csv"\n', "utf-8")
    return tmp_path


def test_names_of_files_tell_the_records(folder):
    study = read_study(folder, strict=True)
    assert study.levels("subject") == ("A", "B", "C")
    assert set(study.levels("site")) == {"cheek", "inner arm"}
    assert set(study.levels("condition")) == {"before", "after"}
    assert study.spectra.sizes == {"record": 12, "wavelength": 31}
    assert study.gaps == ()
    assert study.specular == "included"
    assert study.layers == {"cheek": (0.027, 1.491), "inner arm": (0.041, 1.294)}


def test_a_table_tells_the_records(tmp_path):
    table = np.stack([skin([0.1, 0.006, 0.003]), skin([0.1, 0.009, 0.003])])
    write_table(tmp_path / "a.csv", table, ["one", "two"])
    write_table(tmp_path / "b.nc", table[:1] * 0.9, ["x"])
    rows = [
        "file,label,subject,site,condition,repeat,group,sex,age",
        "a.csv,one,P1,cheek,before,1,sun,F,33",
        "a.csv,two,P1,cheek,before,2,,,",
        "b.nc,,P2,cheek,before,1,shade,M,40-49",
    ]
    study = read_study(listed(tmp_path, rows), strict=True)
    assert_allclose(study.spectra["reflectance"].values[:2], table, rtol=1e-15)
    assert_array_equal(study.spectra["repeat"].values, [1, 2, 1])
    assert_array_equal(study.spectra["group"].values, ["sun", "sun", "shade"])
    assert_array_equal(study.spectra["age_group"].values, ["33", "33", "40-49"])


def test_logs_of_sessions_are_records(tmp_path):
    plan = Plan(sites=("cheek", "back of hand"), repeats=2, warm_up=False)
    on = bench(subject=human())
    for name in ("A", "B"):
        run_session(tmp_path / f"{name}.skinlog", plan, on)
    head = 'pattern = "{subject}.skinlog"\nlabels = "{site}"\n'
    (tmp_path / "study.toml").write_text(f'specular = "excluded"\n{head}', "utf-8")
    study = read_study(tmp_path, strict=True)
    assert study.levels("subject") == ("A", "B")
    assert study.levels("site") == ("cheek", "back of hand")
    expected = read_session(tmp_path / "A.skinlog")
    assert_array_equal(
        study.spectra.reflectance.values[:2], expected.reflectance.values
    )
    (tmp_path / "study.toml").write_text(f'specular = "included"\n{head}', "utf-8")
    with pytest.raises(DataError, match="leaves the surface reflection out"):
        read_study(tmp_path, strict=True)


def test_records_can_be_listed_one_by_one(tmp_path):
    write_table(tmp_path / "a.csv", skin([0.1, 0.006, 0.003]), ["x"])
    (tmp_path / "study.toml").write_text(
        'specular = "included"\n[[record]]\nfile = "a.csv"\nsubject = 7\n'
        'site = "forehead"\n[sites.forehead]\nlike = "cheek"\n',
        "utf-8",
    )
    study = read_study(tmp_path)
    assert study.title == tmp_path.name
    assert study.levels("subject") == ("7",)
    assert study.layers == {"forehead": (0.027, 1.491)}


def test_labels_inside_files_tell_records(tmp_path):
    spectra = np.stack([skin([0.1, oxy, 0.003]) for oxy in (0.005, 0.006, 0.007)])
    labels = ["cheek / 1", "cheek / 2", "calibration"]
    write_table(tmp_path / "s" / "A.csv", spectra, labels)
    (tmp_path / "study.toml").write_text(
        'specular = "included"\npattern = "s/{subject}.csv"\n'
        'labels = "{site} / {repeat}"\n',
        "utf-8",
    )
    study = read_study(tmp_path)
    assert_array_equal(study.spectra["repeat"].values, [1, 2])
    ((what, subject, *_, why),) = gaps_of(study)
    assert (what, subject) == ("left out", "A")
    assert "'calibration' does not follow" in why


def test_a_missing_cell_is_named(folder):
    (folder / "spectra" / "B_inner-arm_after.csv").unlink()
    study = read_study(folder)
    assert gaps_of(study) == [("missing", "B", "inner arm", "after", "no record")]
    with pytest.raises(DataError, match="not whole, 1 gaps; the first is missing: B, "):
        read_study(folder, strict=True)


def test_an_unreadable_file_is_named_and_the_others_are_read(folder):
    broken = folder / "spectra" / "A_cheek_before.csv"
    broken.write_text("wavelength_nm,x\n400,0.3\n410,what\n", "utf-8")
    study = read_study(folder)
    assert study.spectra.sizes["record"] == 11
    ((what, subject, site, condition, why),) = gaps_of(study)
    assert (what, subject, site, condition) == ("left out", "A", "cheek", "before")
    assert "line 3" in why
    assert str(folder) not in why


def test_a_subject_that_is_listed_twice_is_left_out_once(tmp_path):
    for name, oxy in (("a", 0.006), ("b", 0.009)):
        write_table(tmp_path / f"{name}.csv", skin([0.1, oxy, 0.003]), ["x"])
    rows = ["file,subject,site", "a.csv,P1,cheek", "b.csv,P1,cheek"]
    study = read_study(listed(tmp_path, rows))
    assert_array_equal(study.spectra["file"].values, ["a.csv"])
    assert "is there already" in gaps_of(study)[0][-1]


def test_two_people_with_one_name_are_told(tmp_path):
    for name, oxy in (("a", 0.006), ("b", 0.009)):
        write_table(tmp_path / f"{name}.csv", skin([0.1, oxy, 0.003]), ["x"])
    rows = ["file,subject,site,sex", "a.csv,P1,cheek,F", "b.csv,P1,inner arm,M"]
    study = read_study(listed(tmp_path, rows))
    assert study.levels("site") == ("cheek",)
    assert "its sex is 'M', and 'F' elsewhere" in gaps_of(study)[0][-1]


def test_one_spectrum_under_two_subjects_counts_for_neither(tmp_path):
    for name, oxy in (("a", 0.006), ("b", 0.009), ("c", 0.006)):
        write_table(tmp_path / f"{name}.csv", skin([0.1, oxy, 0.003]), ["x"])
    rows = ["file,subject,site", *(f"{n}.csv,{n},cheek" for n in "abc")]
    study = read_study(listed(tmp_path, rows))
    assert study.levels("subject") == ("b",)
    assert [(g.what, g.subject) for g in study.gaps] == [
        ("left out", "a"),
        ("left out", "c"),
    ]


def test_unequal_wavelengths_are_interpolated_and_told(folder):
    fine = np.arange(390.0, 711.0, 5.0)
    weights = [0.1, 0.006, 0.003]
    path = folder / "spectra" / "A_cheek_before.csv"
    write_table(path, skin(weights, bands=fine), ["x"], fine)
    study = read_study(folder)
    assert_array_equal(study.spectra["wavelength"].values, BANDS)
    row = study.spectra["file"].values.tolist().index("spectra/A_cheek_before.csv")
    own = study.spectra["reflectance"].values[row]
    assert_allclose(own, skin(weights), rtol=1e-14)
    ((what, *_, why),) = gaps_of(study)
    assert what == "resampled"
    assert "390-710 nm by 5 and most have 400-700 nm by 10" in why


def test_spectra_that_do_not_span_the_fit_are_left_out(folder):
    short = np.arange(450.0, 701.0, 10.0)
    path = folder / "spectra" / "A_cheek_before.csv"
    write_table(path, skin([0.1, 0.006, 0.003], bands=short), ["x"], short)
    assert "covers 450 to 700 nm" in gaps_of(read_study(folder))[0][-1]


def test_bands_that_were_not_measured_stay_empty(tmp_path):
    spectrum = skin([0.1, 0.006, 0.003])
    spectrum[5] = np.nan
    write_table(tmp_path / "a.nc", [spectrum], ["x"])
    rows = ["file,subject,site", "a.nc,P1,cheek"]
    values = read_study(listed(tmp_path, rows)).spectra["reflectance"].values[0]
    assert_array_equal(np.isnan(values).nonzero()[0], [5])


def test_folders_too_can_tell(folder):
    for path in list((folder / "spectra").iterdir()):
        subject, rest = path.name.split("_", 1)
        (folder / "by" / subject).mkdir(parents=True, exist_ok=True)
        path.rename(folder / "by" / subject / rest)
    toml = folder / "study.toml"
    text = toml.read_text("utf-8")
    toml.write_text(text.replace("spectra/{subject}_", "by/{subject}/"), "utf-8")
    study = read_study(folder, strict=True)
    assert study.levels("subject") == ("A", "B", "C")
    assert study.spectra.sizes["record"] == 12


def test_files_that_do_not_follow_the_pattern_are_told(folder):
    write_table(folder / "spectra" / "notes.csv", skin([0.1, 0.006, 0.003]), ["x"])
    ((what, *_, why),) = gaps_of(read_study(folder))
    assert (what, why[:24]) == ("left out", "its name does not follow")


def test_a_site_of_unknown_thickness_is_left_out_until_told(folder):
    for path in (folder / "spectra").glob("*_cheek_*"):
        path.rename(path.with_name(path.name.replace("cheek", "palm")))
    study = read_study(folder)
    assert study.levels("site") == ("inner arm",)
    assert len(study.gaps) == 6
    toml = folder / "study.toml"
    told = "\n[sites.palm]\nthickness = [0.2, 1.5]\n"
    toml.write_text(toml.read_text("utf-8") + told, "utf-8")
    assert read_study(folder, strict=True).layers["palm"] == (0.2, 1.5)


def test_hands_and_readings_are_found_or_told_missing(folder):
    (folder / "hand.ply").write_text("ply", "utf-8")
    (folder / "gonio.csv").write_text("x", "utf-8")
    toml = folder / "study.toml"
    toml.write_text(
        toml.read_text("utf-8")
        + '[subjects.A]\nmesh = "hand.ply"\nunit = "mm"\n'
        + '[subjects.B]\nscan = "raw.conf"\ngonio = "none.csv"\n'
        + '[subjects.C]\n[subjects.C.gonio]\n"inner arm" = "gonio.csv"\n'
        + "[subjects.D]\nage = 30\n",
        "utf-8",
    )
    study = read_study(folder)
    shape = study.shapes["A"]
    assert (shape.path, shape.unit, shape.raw) == (folder / "hand.ply", "mm", False)
    assert study.gonio == {("C", "inner arm"): folder / "gonio.csv"}
    missing = [(g.subject, g.file) for g in study.gaps if g.why == "no such file"]
    assert missing == [("B", "raw.conf"), ("B", "none.csv")]
    assert {g.subject for g in study.gaps if g.why == "no record"} == {"D"}


@pytest.mark.parametrize(
    ("toml", "told"),
    [
        ("title = 3", "title is of the wrong kind"),
        ("titel = 'x'", "unknown key 'titel'"),
        ("pattern = 'x'", "say how the surface reflection was measured"),
        ("specular = 'in'\nrecord = []", "unknown specular"),
        ("specular = 0.9\nrecord = []", "specular must be in"),
        ("specular = 'included'", "list the records in one way.*got none"),
        (
            "specular = 'included'\nrecords = 'a.csv'\npattern = '{subject}.csv'",
            "got records and pattern",
        ),
        ("specular = 'included'\nrecords = 'none.csv'", "none.csv: no such file"),
        ("specular = 'included'\npattern = 's/{subject}.csv'", "must tell {site}"),
        ("specular = 'included'\npattern = '{name}_{site}.csv'", "got {name}"),
        (
            "specular = 'included'\npattern = '/{subject}_{site}.csv'",
            "must be a path in",
        ),
        ("specular = 'included'\npattern = '{subject}_{site}.csv'", "it lists none"),
        ("specular = 'included'\nrecords = 'a.csv'\nlabels = 'x'", "labels goes with"),
        ("specular = 'included'\nrecord = [1]", r"write \[\[record\]\]"),
        ("specular = 'included'\nrecord = []\nsites = {x = 1}", r"write \[sites.x\]"),
        ("specular = 'included'\nrecord = []\nsubjects.A.name = 'Ann'", "unknown key"),
        ("not toml", "not a TOML file"),
    ],
)
def test_a_wrong_study_file_is_refused_in_one_line(tmp_path, toml, told):
    (tmp_path / "study.toml").write_text(toml, "utf-8")
    with pytest.raises(DataError, match=told) as error:
        read_study(tmp_path)
    assert "\n" not in str(error.value)
    assert str(tmp_path) in str(error.value)


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        (["file,subject,site"], "a header and a line for each"),
        (["file,subject,place", "a,b,c"], "unknown column 'place'"),
        (["file,subject,file", "a,b,c"], "two columns have the same name"),
        (["file,subject,site", "a,b"], "line 2: 2 cells where the first line has 3"),
        (["file,subject,site", "a,,cheek"], "its subject is not told"),
        (["subject,site", "a,cheek"], "its file is not told"),
        (["file,subject,site,repeat", "a,b,cheek,1.5"], "its repeat must be 1, 2"),
        (["file,subject,site", "a.csv,b,cheek"], "no such file"),
    ],
)
def test_a_wrong_table_of_records_is_told(tmp_path, rows, told):
    with pytest.raises(DataError, match=told):
        read_study(listed(tmp_path, rows))


@pytest.mark.parametrize(
    "told", ["thickness = [0.1]", "thickness = [0, 1]", "like = 'nose'", "is = 'x'"]
)
def test_wrong_layers_are_refused(folder, told):
    toml = folder / "study.toml"
    toml.write_text(f"{toml.read_text('utf-8')}[sites.cheek]\n{told}\n", "utf-8")
    with pytest.raises(DataError, match=r"cheek|nose"):
        read_study(folder)


def test_a_folder_without_a_study_is_refused(tmp_path):
    with pytest.raises(DataError, match=r"study\.toml: no such file"):
        read_study(tmp_path / "none")
    (tmp_path / "file").write_text("x", "utf-8")
    with pytest.raises(DataError, match="is a file; name the folder"):
        read_study(tmp_path / "file")


def test_the_example_has_the_gap_that_it_says():
    study = read_study("docs/examples/study")
    assert gaps_of(study) == [
        ("missing", "H", "inner arm", "after sun", "no record"),
    ]
    assert study.spectra.sizes["record"] == 62
    assert set(study.shapes) == {"A"}
