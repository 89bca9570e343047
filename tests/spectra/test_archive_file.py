"""Archives as netCDF files: whole, broken, hostile."""

import numpy as np
import pytest
import xarray
from numpy.testing import assert_array_equal

from skinviz import ArgumentError, DataError, SkinvizError, load_archive
from skinviz.spectra.archive_file import write_archive
from skinviz.spectra.archives import ARCHIVES


@pytest.fixture(scope="module")
def few():
    """Records with text beyond ASCII, blanks and missing bands."""
    few = load_archive("issa").isel(record=[0, 5000, 8306]).load()
    return few.assign_coords(group=("record", np.array(["Köln µ", "", "x y"], object)))


@pytest.fixture
def file(few, tmp_path):
    return write_archive(tmp_path / "few.nc", few)


@pytest.mark.parametrize("name", ARCHIVES)
def test_a_shipped_archive_survives_a_file(name, tmp_path):
    archive = load_archive(name)
    file = write_archive(tmp_path / "whole.nc", archive)
    xarray.testing.assert_identical(load_archive(file), archive)
    assert file.stat().st_size < archive.nbytes + 50_000


def test_text_beyond_ascii_and_blanks_survive(few, file):
    xarray.testing.assert_identical(load_archive(file), few)
    assert isinstance(load_archive(file).group.values[0], str)


def test_flags_are_computed_anew_for_the_part_that_is_kept(tmp_path):
    whole = load_archive("issa")
    first = np.flatnonzero(whole.duplicate.values)[:1]
    part = load_archive(write_archive(tmp_path / "part.nc", whole.isel(record=first)))
    assert not part.duplicate.any()


def test_another_suffix_or_dataset_is_refused(few, tmp_path):
    with pytest.raises(ArgumentError, match=r"suffix of an archive.*\.nc"):
        write_archive(tmp_path / "a.csv", few)
    with pytest.raises(ArgumentError, match=r"needs site \(record\)"):
        write_archive(tmp_path / "a.nc", few.drop_vars("site"))
    unsaid = few.copy()
    del unsaid.attrs["specular"]
    with pytest.raises(ArgumentError, match="needs the attribute specular"):
        write_archive(tmp_path / "a.nc", unsaid)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_leaves_nothing(few, tmp_path):
    (tmp_path / "taken").write_text("x", "utf-8")
    with pytest.raises(SkinvizError, match="cannot write"):
        write_archive(tmp_path / "taken" / "a.nc", few)


def test_what_is_no_archive_is_refused(file, tmp_path):
    bad = tmp_path / "bad.nc"
    with pytest.raises(DataError, match="no such file"):
        load_archive(bad)
    bad.write_bytes(b"")
    with pytest.raises(DataError, match="empty"):
        load_archive(bad)
    bad.write_bytes(b"wavelength_nm,a\n400,0.1\n")
    with pytest.raises(DataError, match="no netCDF file that can be read"):
        load_archive(str(bad))
    whole = file.read_bytes()
    bad.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(DataError, match="no netCDF file that can be read"):
        load_archive(bad)
    xarray.Dataset({"x": ("t", [1.0])}).to_netcdf(bad, engine="h5netcdf")
    with pytest.raises(DataError, match=r"no archive, reflectance \(record, wave"):
        load_archive(bad)
    with pytest.raises(DataError, match="a folder"):
        load_archive(tmp_path)


SPOILT = {
    "infinite": ({"reflectance": np.inf}, {}, "a reflectance is infinite"),
    "order": ({"wavelength": 500.0}, {}, "wavelengths do not ascend"),
    "specular": ({}, {"specular": "shiny"}, "unknown specular"),
}


@pytest.mark.parametrize(("values", "attributes", "told"), SPOILT.values(), ids=SPOILT)
def test_spoilt_contents_are_refused(few, values, attributes, told, tmp_path):
    spoilt = few.copy(deep=True)
    for name, value in values.items():
        array = spoilt[name].values.copy()
        array.flat[0] = value
        spoilt[name] = (spoilt[name].dims, array)
    file = write_archive(tmp_path / "a.nc", spoilt.assign_attrs(attributes))
    with pytest.raises(DataError, match=told):
        load_archive(file)


def test_numbers_for_text_and_text_for_numbers_are_refused(few, tmp_path):
    kept = few.drop_vars(["duplicate", "repeats", "two_sexes"])
    path = tmp_path / "a.nc"
    kept.assign_coords(site=("record", [1, 2, 3])).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(DataError, match="site must be text"):
        load_archive(path)
    text = kept.reflectance.astype(str)
    kept.assign(reflectance=text).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(DataError, match="reflectance must be numbers"):
        load_archive(path)


def test_a_file_that_claims_an_absurd_size_is_refused(few, tmp_path):
    import h5netcdf

    path = write_archive(tmp_path / "a.nc", few)
    with h5netcdf.File(path, "a") as file:
        file.dimensions["big"] = 200_000_000
        file.create_variable("zeros", ("big",), "f8", chunks=(1_000_000,))
    assert path.stat().st_size < 1_000_000
    with pytest.raises(DataError, match=r"claims to hold 1.6 GB"):
        load_archive(path)


def test_an_empty_archive_is_refused(few, tmp_path):
    path = tmp_path / "a.nc"
    few.isel(record=[]).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(DataError, match="holds no spectra"):
        load_archive(path)


def test_a_file_selects_and_counts_like_the_shipped(file, few):
    from skinviz.spectra.archive_selection import select

    found = select(load_archive(file), site=few.site.values[0])
    assert_array_equal(found.reflectance, few.reflectance[:1])
