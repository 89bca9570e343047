"""What is exported is read back by whoever needs it."""

from pathlib import Path

import numpy as np
import pytest
from benches import bench, human, run_session
from numpy.testing import assert_allclose, assert_array_equal

import skinviz
from skinviz.errors import ArgumentError
from skinviz.instruments.derive import derive, read_session
from skinviz.instruments.export import _named, export_spectra, write_lobe
from skinviz.instruments.lobe import lobe_of
from skinviz.instruments.plan import Plan
from skinviz.instruments.skinlog import read_log

PLAN = Plan(
    sites=("back of hand", "cheek"),
    subject="P07",
    illumination=(-30.0, 20.0, 50.0),
    viewing=60.0,
    states=("s", "p"),
    repeats=2,
    warm_up=False,
)


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    path = tmp_path_factory.mktemp("export") / "a.skinlog"
    run_session(path, PLAN, bench(subject=human()))
    log = read_log(path)
    return path, log, derive(log)


def test_netcdf_has_everything(session, tmp_path):
    path, log, derived = session
    (file,) = export_spectra(tmp_path / "a.nc", log, derived, "a.skinlog")
    found = skinviz.read_spectra(file)
    assert found.label.values.tolist() == [
        "back of hand 20/60",
        "back of hand 50/60",
        "cheek 20/60",
        "cheek 50/60",
    ]
    assert_allclose(found.uncertainty, read_session(path).uncertainty)
    assert found.attrs["specular"] == "excluded"
    assert set(found.subject.values) == {"P07"}
    assert found.radiance_factor.dims == (
        "body_site",
        "illumination",
        "state",
        "wavelength",
    )
    at = {"body_site": "cheek", "illumination": 50.0}
    part = derived.parts["cheek", 50.0]
    assert_array_equal(found.specular.sel(at), part.specular)
    p = found.radiance_factor.sel(at | {"state": "p"})
    assert_array_equal(p, derived.factors["cheek", 50.0, "p"].value)


def test_other_formats_have_the_bands_that_all_have(session, tmp_path):
    _, log, derived = session
    whole = export_spectra(tmp_path / "a.csv", log, derived, "a.skinlog")[0]
    found = skinviz.read_spectra(whole)
    assert found.sizes == {"record": 4, "wavelength": 101}
    files = export_spectra(tmp_path / "a.spdx", log, derived, "a.skinlog")
    assert files[0].name == "a-back-of-hand-20-60.spdx"
    one = skinviz.read_spectra(files[0])
    assert_array_equal(one.reflectance.values[0], found.reflectance.values[0])
    assert "PR-655" in one.attrs["instrument"]


def test_the_lobe_is_read_for_its_fit(session, tmp_path):
    _, _, derived = session
    lobe = lobe_of(derived, "cheek")
    data = skinviz.read_gonio(write_lobe(tmp_path / "g.csv", lobe, "a log"))
    assert_allclose(np.rad2deg(data.illumination), [20, 50])
    assert_array_equal(data.specular, lobe.specular)
    assert_array_equal(data.uncertainty, lobe.uncertainty)


def test_unknown_suffixes_are_refused(session, tmp_path):
    _, log, derived = session
    with pytest.raises(ArgumentError, match=r"\.nc"):
        export_spectra(tmp_path / "a.xls", log, derived, "a.skinlog")
    with pytest.raises(ArgumentError, match=r"\.csv"):
        write_lobe(tmp_path / "g.txt", lobe_of(derived, "cheek"), "")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("labels", "names"),
    [
        (["Back of hand", "cheek"], ["a-back-of-hand.spdx", "a-cheek.spdx"]),
        (["手", "Stirn Ä"], ["a-手.spdx", "a-stirn-ä.spdx"]),
        (["cheek 1", "cheek-1"], ["a-1-cheek-1.spdx", "a-2-cheek-1.spdx"]),
        (["?", "!"], ["a-1.spdx", "a-2.spdx"]),
    ],
)
def test_no_spectrum_is_written_over_another(labels, names):
    assert [path.name for path in _named(Path("a.spdx"), labels)] == names
