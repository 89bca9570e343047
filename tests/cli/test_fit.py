"""``skinviz fit``: lists and cubes, models, every file it writes, refusals."""

import json
import re

import numpy as np
import pandas as pd
import pytest
import xarray
from numpy.testing import assert_allclose, assert_array_equal
from PIL import Image
from rival_model import rival  # noqa: F401 - a fixture

from skinviz import fit_skin, skin_model, skin_models, write_spectra
from skinviz.cli.fit_text import MOST_ROWS
from skinviz.cli.main import main
from skinviz.cli.output import progress_bar
from skinviz.scene.scene_skin import skin_from_fit_file

NM = np.arange(400.0, 701.0, 10.0)
MODEL = skin_model(site="cheek", specular="included")
TRUE = np.array([[0.1, 0.008, 0.004], [0.2, 0.006, 0.005], [0.05, 0.01, 0.0]])
CHEEK = ("--site", "cheek")


def noisy(weights, seed=1, nm=NM):
    """Return spectra of known weights with a thousandth of noise."""
    spectra = MODEL.measured(weights, nm)
    return spectra + np.random.default_rng(seed).normal(0, 1e-3, spectra.shape)


def as_list(reflectance, nm=NM, specular="included"):
    """Return spectra as read_spectra does."""
    names = [f"skin {i}" for i in range(len(reflectance))]
    return xarray.Dataset(
        {"reflectance": (("record", "wavelength"), reflectance)},
        coords={"wavelength": nm, "label": ("record", names)},
        attrs={"specular": specular},
    )


@pytest.fixture
def skins(tmp_path):
    return write_spectra(tmp_path / "skins.csv", as_list(noisy(TRUE)))


@pytest.fixture
def cube(tmp_path):
    """A cube of 5 lines and 4 samples: one pixel missing, one a highlight."""
    weights = np.stack(
        np.broadcast_arrays(
            np.linspace(0.05, 0.3, 5)[:, None], np.linspace(0.004, 0.012, 4), 0.004
        ),
        axis=-1,
    )
    values = noisy(weights).astype(np.float32)
    values[0, 0] = np.nan
    values[2, 3] = 1.8
    spectra = xarray.Dataset(
        {"reflectance": (("line", "sample", "wavelength"), values)},
        coords={"wavelength": NM},
        attrs={"specular": "included"},
    )
    return write_spectra(tmp_path / "cube.hdr", spectra)


@pytest.fixture
def run(capsys):
    """Run the verb; return its exit code, and what it said."""

    def call(*words):
        code = main(["fit", *map(str, words)])
        told = capsys.readouterr()
        return code, told.out, told.err

    return call


# Files of spectra ----------------------------------------------------------------


def test_several_files_are_fitted_each_on_its_own_wavelengths(run, tmp_path, skins):
    fine = np.arange(380.0, 731.0, 5.0)
    other = tmp_path / "more.nc"
    write_spectra(other, as_list(noisy(TRUE[:1], 2, fine), fine))
    out = tmp_path / "out" / "both.csv"
    code, said, told = run(skins, other, *CHEEK, "-o", out)
    assert code == 0
    assert "skins/skin 0" in said
    assert "more/skin 0" in said
    assert told.splitlines()[-2:] == [
        "[4/5] fit two-layer, more.nc",
        "[5/5] write both.csv",
    ]
    rows = pd.read_csv(out)
    assert rows["label"].tolist() == [
        *(f"skins/skin {i}" for i in range(3)),
        "more/skin 0",
    ]
    assert rows["n_bands"].tolist() == [31, 31, 31, 61]
    alone = fit_skin(noisy(TRUE), NM, MODEL)
    assert_allclose(rows["w_m"][:3], alone.values[:, 0], rtol=1e-5)
    assert_allclose(rows["w_h_upper"][:3], alone.interval[:, 1, 1], rtol=1e-4)


def test_files_of_one_name_keep_their_folders(run, tmp_path):
    files = [tmp_path / folder / "skin.csv" for folder in ("a", "b")]
    for file in files:
        write_spectra(file, as_list(noisy(TRUE[:1])))
    code, said, _ = run(*files, *CHEEK, "--json")
    assert code == 0
    told = json.loads(said)
    assert told["file"] == [str(file) for file in files]
    assert [fit["label"] for fit in told["fits"]] == [
        f"{file}/skin 0" for file in files
    ]


def test_a_file_may_declare_its_scale(run, tmp_path):
    values = 100 * noisy(TRUE[0])
    rows = [f"{nm:g},{value:.6f}" for nm, value in zip(NM, values, strict=True)]
    text = "# scale: percent\n# specular: included\nwavelength_nm,a\n" + "\n".join(rows)
    file = tmp_path / "percent.csv"
    file.write_text(text, encoding="utf-8")
    code, said, _ = run(file, *CHEEK, "--json")
    assert code == 0
    found = json.loads(said)["fits"][0]["parameters"]["w_m"]["value"]
    assert found == pytest.approx(0.1, rel=0.05)
    assert run(file, *CHEEK, "--scale", "fraction")[0] == 1


def test_a_known_uncertainty_sets_the_intervals(run, skins):
    widths = []
    for sigma in ("0.001", "0.002"):
        _, said, _ = run(skins, *CHEEK, "--uncertainty", sigma, "--json")
        weight = json.loads(said)["fits"][0]["parameters"]["w_m"]
        widths.append(weight["upper"] - weight["lower"])
    assert widths[1] == pytest.approx(2 * widths[0], rel=1e-6)


@pytest.mark.parametrize("name", skin_models())
def test_every_model_is_fitted_drawn_and_written(run, skins, tmp_path, name):
    out, plot = tmp_path / "fit.json", tmp_path / "fit.png"
    words = (skins, *CHEEK, "--model", name, "-o", out, "--plot", plot)
    code, said, _ = run(*words)
    assert code == 0
    assert max(map(len, said.splitlines()[:-3])) <= 100
    skin = skin_from_fit_file(out, 1)
    assert skin.model.name == name
    assert skin.values.shape == (len(skin.model.parameters),)
    with Image.open(plot) as picture:
        assert picture.size[0] > 1000


# What is written -------------------------------------------------------------------


def test_a_scene_reads_the_json(run, skins, tmp_path):
    out = tmp_path / "fit.json"
    assert run(skins, *CHEEK, "-o", out)[0] == 0
    skin = skin_from_fit_file(out, record=1)
    assert skin.model.description == MODEL.description
    assert_allclose(skin.values, fit_skin(noisy(TRUE), NM, MODEL).values[1], rtol=1e-5)


def test_a_scene_reads_the_json_of_a_cube(run, cube, tmp_path):
    out = tmp_path / "fit.json"
    assert run(cube, *CHEEK, "-o", out)[0] == 0
    fits = json.loads(out.read_text("utf-8"))["fits"]
    assert fits[7]["label"] == "line 1 sample 3"
    assert fits[0]["parameters"]["w_m"]["value"] is None
    assert skin_from_fit_file(out, record=7).values[0] == pytest.approx(
        0.1125, rel=0.05
    )


def test_netcdf_of_a_list_opens_with_plain_xarray(run, skins, tmp_path):
    out = tmp_path / "fit.nc"
    assert run(skins, *CHEEK, "-o", out)[0] == 0
    fit = fit_skin(noisy(TRUE), NM, MODEL)
    with xarray.open_dataset(out) as table:
        assert table["label"].values.tolist() == ["skin 0", "skin 1", "skin 2"]
        assert table["status"].values.tolist() == fit.status.tolist()
        first = table["value"].sel(parameter="w_m")
        assert_allclose(first, fit.values[:, 0], rtol=1e-5)
        assert_allclose(table["measured"], noisy(TRUE), rtol=1e-12)
        assert_allclose(table["fitted"], fit.fitted, rtol=1e-5)
        assert_allclose(table["bic"], fit.bic, rtol=1e-5)
        shares = table["oxygen_saturation_interval"]
        assert_allclose(shares, fit.oxygen_saturation_interval, atol=1e-4)
        assert json.loads(table.attrs["description"]) == MODEL.description
        assert table["wavelength"].attrs["units"] == "nm"
        assert all(
            "units" in v.attrs for n, v in table.data_vars.items() if n != "status"
        )
    # What skinviz wrote as a fit is not taken for measured spectra.
    code, _, told = run(out, *CHEEK)
    assert code == 1
    assert "holds a fit" in told


def test_netcdf_of_a_cube_keeps_lines_and_samples(run, cube, tmp_path):
    out = tmp_path / "fit.nc"
    assert run(cube, *CHEEK, "-o", out)[0] == 0
    with xarray.open_dataset(out) as table:
        assert table["sse"].dims == ("line", "sample")
        assert table["value"].sizes == {"line": 5, "sample": 4, "parameter": 3}
        assert table["status"][2, 3] == "refused"
        assert_allclose(table["value"][4, :, 0], 0.3, rtol=0.1)
        assert table.attrs["curves"] == "all"


def test_envi_maps_are_read_by_the_spectral_package(run, cube, tmp_path):
    from spectral.io import envi

    out, again = tmp_path / "maps.hdr", tmp_path / "again.nc"
    for _ in range(2):  # its own files it may write over
        assert run(cube, *CHEEK, "-o", out)[0] == 0
    assert run(cube, *CHEEK, "-o", again)[0] == 0
    maps = envi.open(str(out))
    names = maps.metadata["band names"]
    assert names == [
        *("w_m", "w_h", "w_dh", "oxygen_saturation", "blood_fraction"),
        *("rmse", "delta_e_2000", "status"),
    ]
    values = np.asarray(maps.open_memmap())
    assert values.dtype == np.float32
    with xarray.open_dataset(again) as table:
        assert_array_equal(values[..., :3], table["value"].astype(np.float32))
        assert_array_equal(values[..., 6], table["delta_e"].astype(np.float32))
    codes = np.zeros((5, 4))
    codes[0, 0] = codes[2, 3] = 3
    assert_array_equal(values[..., 7], codes)
    assert "3 refused" in maps.metadata["description"]


def test_csv_of_a_cube_has_a_row_a_pixel(run, cube, tmp_path):
    out = tmp_path / "fit.csv"
    assert run(cube, *CHEEK, "-o", out)[0] == 0
    rows = pd.read_csv(out)
    assert rows["line"].tolist() == np.repeat(range(5), 4).tolist()
    assert rows["sample"].tolist() == 5 * [0, 1, 2, 3]
    assert rows.loc[rows["status"] == "refused", "w_m"].isna().all()


def test_maps_count_what_was_refused(run, cube, tmp_path):
    maps = tmp_path / "maps.svg"
    code, said, _ = run(cube, *CHEEK, "--maps", maps)
    assert code == 0
    assert str(maps) in said
    assert maps.read_text("utf-8").startswith("<?xml")


# What is said ------------------------------------------------------------------------


def test_many_spectra_are_summed_up_unless_all_are_asked_for(run, tmp_path):
    n = MOST_ROWS + 1
    file = tmp_path / "many.csv"
    write_spectra(file, as_list(noisy(np.tile(TRUE[:1], (n, 1)))))
    _, said, _ = run(file, *CHEEK)
    assert f"two-layer, {n} spectra: {n} converged" in said
    assert "skin 40" not in said
    median = re.search(r"^w_m +\S+ +\S+ +(\S+)", said, re.MULTILINE).group(1)
    assert float(median) == pytest.approx(0.1, rel=0.02)
    _, said, _ = run(file, *CHEEK, "--all")
    assert "skin 40" in said
    _, said, _ = run(file, *CHEEK, "--json")
    told = json.loads(said)
    assert len(told["fits"]) == n
    assert told["summary"]["two-layer"]["status"] == {"converged": n}


def test_what_cannot_be_told_apart_is_said(run, tmp_path):
    # Dark skin hides which of the two bloods it is.
    weights = np.array([[0.35, 0.005, 0.004], [0.01, 0.005, 0.004]])
    file = tmp_path / "dark.csv"
    write_spectra(file, as_list(noisy(weights)))
    fit = fit_skin(noisy(weights), NM, MODEL)
    pairs = fit.indistinct()
    assert pairs
    _, said, _ = run(file, *CHEEK)
    (line,) = [row for row in said.splitlines() if row.startswith("cannot be told")]
    for (first, second), where in pairs.items():
        assert f"{first} and {second} in {where.sum()} of 2 spectra" in line


def test_a_refused_spectrum_is_a_row_of_dashes(run, tmp_path):
    values = noisy(TRUE)
    values[1] = np.nan
    file = tmp_path / "gap.nc"
    write_spectra(file, as_list(values))
    plot = tmp_path / "gap.png"
    code, said, _ = run(file, *CHEEK, "--plot", plot)
    assert code == 0
    assert re.search(r"^skin 1( +-)+ +refused$", said, re.MULTILINE)
    assert "refused: too few bands" in said
    assert plot.exists()


def test_progress_is_a_bar_that_moves_in_a_terminal(monkeypatch, capsys):
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setenv("COLUMNS", "100")
    with progress_bar(2) as begin:
        begin("read")
        begin("fit")
        advance = begin.counting(5000)
        advance(2000)
        advance(3000)
    told = capsys.readouterr().err
    assert "5000/5000" in told
    assert "2/2" in told


# Several models -------------------------------------------------------------------


BOTH = ("--model", "two-layer", "--model", "rival")


def test_models_are_compared_spectrum_by_spectrum(run, skins, rival):  # noqa: F811
    code, said, _ = run(skins, *CHEEK, *BOTH)
    assert code == 0
    data = noisy(TRUE)
    ours = fit_skin(data, NM, MODEL).bic
    theirs = fit_skin(
        data, NM, skin_model("rival", site="cheek", specular="included")
    ).bic
    rows = [
        row.split() for row in said.splitlines() if row.startswith(("two-", "rival"))
    ]
    assert [row[0] for row in rows if len(row) > 5] == 3 * ["two-layer", "rival"]
    marked = [row[0] for row in rows if any(cell.endswith("*") for cell in row)]
    assert marked == np.where(ours < theirs, "two-layer", "rival").tolist()
    assert "*: the least BIC" in said


def test_files_have_the_model_as_a_further_key(run, skins, tmp_path, rival):  # noqa: F811
    outs = {kind: tmp_path / f"fit.{kind}" for kind in ("json", "csv", "nc", "png")}
    for kind in ("json", "csv", "nc"):
        assert run(skins, *CHEEK, *BOTH, "-o", outs[kind])[0] == 0
    told = json.loads(outs["json"].read_text("utf-8"))
    assert list(told["models"]) == ["two-layer", "rival"]
    alone = told["models"]["two-layer"]
    assert alone["format"] == "skinviz fit 1"
    assert alone["fits"][0]["parameters"].keys() == {"w_m", "w_h", "w_dh"}
    rows = pd.read_csv(outs["csv"])
    assert rows["model"].tolist() == 3 * ["two-layer"] + 3 * ["rival"]
    # The CSV has as many digits as anyone reads: 12.
    assert rows["bic"].tolist()[:3] == pytest.approx([f["bic"] for f in alone["fits"]])
    assert rows.loc[rows["model"] == "rival", "w_h"].isna().all()
    assert rows.loc[rows["model"] == "rival", "blood"].notna().all()
    with xarray.open_dataset(outs["nc"]) as table:
        assert table["model"].values.tolist() == ["two-layer", "rival"]
        assert table["parameter"].values.tolist() == ["w_m", "w_h", "w_dh", "blood"]
        assert table["measured"].dims == ("record", "wavelength")
        assert_allclose(table["bic"].values.ravel(), rows["bic"], rtol=1e-11)
        assert_allclose(
            table["value"].sel(model="rival", parameter="blood"), rows["blood"][3:]
        )
    assert run(skins, *CHEEK, *BOTH, "--plot", outs["png"])[0] == 0


def test_a_scene_refuses_a_file_of_several_models(run, skins, tmp_path, rival):  # noqa: F811
    from skinviz import DataError

    out = tmp_path / "fit.json"
    assert run(skins, *CHEEK, *BOTH, "-o", out)[0] == 0
    with pytest.raises(DataError, match="holds fits of several models"):
        skin_from_fit_file(out)


def test_many_spectra_count_each_models_wins(run, cube, rival, monkeypatch):  # noqa: F811
    monkeypatch.setattr("skinviz.cli.fit_text.MOST_ROWS", 10)
    _, said, _ = run(cube, *CHEEK, *BOTH)
    wins = [int(n) for n in re.findall(r"least BIC in (\d+)", said)]
    assert sum(wins) == 18  # of 20, two refused


def test_envi_maps_name_the_model(run, cube, tmp_path, rival):  # noqa: F811
    out = tmp_path / "maps.hdr"
    assert run(cube, *CHEEK, *BOTH, "-o", out)[0] == 0
    assert "two-layer w_m" in out.read_text("utf-8")
    assert "rival blood" in out.read_text("utf-8")


# Refusals -------------------------------------------------------------------------


def refused(result, *expected):
    """Check that it is one line that says what is expected, and exit code 1."""
    code, said, told = result
    assert code == 1
    assert not said
    last = told.strip().splitlines()[-1]
    assert last.startswith("skinviz: ")
    for words in expected:
        assert words in last


def test_outputs_that_do_not_suit_the_spectra_are_refused(run, skins, cube, tmp_path):
    before = sorted(tmp_path.iterdir())
    refused(run(cube, *CHEEK, "--plot", tmp_path / "x.png"), "is a cube; use --maps")
    refused(run(skins, *CHEEK, "--maps", tmp_path / "x.png"), "0 cubes", "use --plot")
    refused(run(skins, *CHEEK, "-o", tmp_path / "x.hdr"), "write .csv, .json or .nc")
    refused(run(skins, cube, *CHEEK, "-o", tmp_path / "x.nc"), "1 cubes and 1 lists")
    for option in ("--out", "--plot", "--maps"):
        refused(run(skins, *CHEEK, option, "x.doc"), f"suffix of {option} '.doc'")
    assert sorted(tmp_path.iterdir()) == before


def test_an_input_is_never_written_over(run, skins, cube):
    refused(run(skins, *CHEEK, "-o", skins), "name another")
    refused(run(cube, *CHEEK, "-o", cube), "name another")
    raw = cube.with_suffix(".bip").read_bytes()
    other = cube.with_name("own.hdr")
    other.with_suffix(".bsq").write_bytes(b"somebody's")
    refused(run(cube, *CHEEK, "-o", other), "own.bsq lies beside it")
    assert other.with_suffix(".bsq").read_bytes() == b"somebody's"
    assert cube.with_suffix(".bip").read_bytes() == raw


def test_too_many_spectra_for_a_format_are_refused_before_the_fit(
    run, cube, tmp_path, monkeypatch
):
    monkeypatch.setattr("skinviz.cli.fit_inputs.MOST", {".json": 19, ".csv": 20})
    monkeypatch.setattr("skinviz.cli.fit.MOST", {".json": 19})
    said = run(cube, *CHEEK, "-o", tmp_path / "x.json")
    refused(said, "20 spectra are too many for .json, at most 19; write .nc or .hdr")
    assert "fit two-layer" not in said[2]
    assert run(cube, *CHEEK, "-o", tmp_path / "x.csv")[0] == 0
    _, told, _ = run(cube, *CHEEK, "--json")
    assert json.loads(told).keys() == {"summary", "files"}


def test_what_is_missing_or_contradicts_is_told(run, skins, tmp_path):
    bare = tmp_path / "bare.csv"
    bare.write_text(re.sub("(?m)^# specular.*\n", "", skins.read_text()), "utf-8")
    refused(run(bare, *CHEEK), "bare.csv does not say", "--specular excluded")
    refused(run(skins), "give exactly one of site and thickness")
    refused(run(skins, "--site", "nose"), "unknown body site 'nose'", "cheek")
    refused(run(skins, *CHEEK, "--model", "three"), "unknown skin model", "two-layer")
    refused(run(skins, *CHEEK, "--uncertainty", "-1"), "--uncertainty", "above 0")
    refused(run(skins, *CHEEK, "--uncertainty", "nan"), "--uncertainty", "above 0")
    refused(run(skins, skins, *CHEEK), "given 2 times")
    twice = ("--model", "two-layer", "--model", "two-layer")
    refused(run(skins, *CHEEK, *twice), "--model two-layer is given 2 times")
    other = tmp_path / "other.csv"
    write_spectra(other, as_list(noisy(TRUE), specular="excluded"))
    refused(run(skins, other, *CHEEK), "skins.csv was measured", "runs of their own")
    short = tmp_path / "short.csv"
    write_spectra(short, as_list(noisy(TRUE)[:, :10], NM[:10]))
    refused(run(short, *CHEEK), "short.csv: a fit needs spectra that span 400 to 700")


def test_maps_show_one_model(run, cube, tmp_path, rival):  # noqa: F811
    told = run(cube, *CHEEK, *BOTH, "--maps", tmp_path / "x.png")
    refused(told, "--maps shows one model")


def test_no_file_is_wrong_usage(run):
    assert run(*CHEEK)[0] == 2
    assert run("x.csv", "--uncertainty", "much")[0] == 2


def test_what_is_free_goes_to_the_extended_model_alone(run, skins):
    words = ("--model", "two-layer", "--model", "extended", "--free", "epidermis")
    code, said, _ = run(skins, *CHEEK, *words, "--json")
    assert code == 0
    models = json.loads(said)["models"]
    weights = ["w_m", "w_h", "w_dh"]
    assert list(models["two-layer"]["fits"][0]["parameters"]) == weights
    assert list(models["extended"]["fits"][0]["parameters"]) == [*weights, "epidermis"]
    refused(run(skins, *CHEEK, "--free", "epidermis"), "--free is for --model extended")
