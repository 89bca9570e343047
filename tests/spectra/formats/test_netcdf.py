"""netCDF: all that spectra carry comes back, for us and for plain xarray."""

import re
import warnings

import h5py
import numpy as np
import pytest
import xarray
from numpy.testing import assert_array_equal
from spectra_tables import skin_like, spectra_cube, spectra_list

from skinviz import (
    ArgumentError,
    DataError,
    fit_skin,
    read_spectra,
    skin_model,
    write_spectra,
)

GAPS = skin_like(3, 4)
GAPS[0, 0] = GAPS[2, 1:3] = np.nan
LIST = spectra_list(
    GAPS,
    ["Ä/β", "two\nlines", ""],
    [400.25, 555.123456789, 632.8, 700],
    source="International Skin Spectra Archive",
    specular=0.03,
    geometry="d/8",
    comment="a\nb",
    licence="CC BY 4.0",
    repeats=3,
    gains=np.array([1.5, 2.5]),
).assign_coords(
    subject=("record", ["7", "8", "9"]),
    duplicate=("record", [True, False, True]),
    age=("record", [31, 45, 60]),
)
CUBE = spectra_cube(skin_like(3, 2, 4, dtype=np.float32), specular="excluded")
CUBE.reflectance[0, 1, 2] = np.nan


@pytest.fixture
def saved(tmp_path):
    """Return a function that saves a dataset by plain xarray."""

    def save(dataset):
        path = tmp_path / "hand.nc"
        with warnings.catch_warnings(action="ignore"):  # of what the tests break
            dataset.to_netcdf(path, engine="h5netcdf")
        return path

    return save


@pytest.mark.parametrize("spectra", [LIST, CUBE], ids=["list", "cube"])
def test_everything_comes_back_exactly(tmp_path, spectra):
    path = write_spectra(tmp_path / "hand.nc", spectra)
    found = read_spectra(path)
    expected = (
        spectra if "source" in spectra.attrs else spectra.assign_attrs(source=str(path))
    )
    xarray.testing.assert_identical(found, expected)
    assert found.reflectance.dtype == spectra.reflectance.dtype
    xarray.testing.assert_identical(
        read_spectra(write_spectra(tmp_path / "again.nc", found)), found
    )


@pytest.mark.parametrize("spectra", [LIST, CUBE], ids=["list", "cube"])
def test_plain_xarray_opens_it(tmp_path, spectra):
    path = write_spectra(tmp_path / "hand.nc", spectra)
    with xarray.open_dataset(path, engine="h5netcdf") as opened:
        xarray.testing.assert_identical(opened.load(), spectra)


def test_other_variables_are_handed_on(saved):
    noise = LIST.assign(uncertainty=(("record", "wavelength"), np.ones((3, 4))))
    assert_array_equal(read_spectra(saved(noise)).uncertainty, np.ones((3, 4)))


def test_the_wavelength_axis_comes_last(saved):
    turned = CUBE.transpose("wavelength", "sample", "line")
    found = read_spectra(saved(turned)).reflectance
    assert found.dims == ("line", "sample", "wavelength")
    assert found.values.flags.c_contiguous
    assert_array_equal(found, CUBE.reflectance)


def test_units_of_wavelength_and_reflectance_are_converted(saved):
    um = ("wavelength", [0.41, 0.57, 0.58, 0.7], {"units": "um"})
    percent = (("record", "wavelength"), GAPS * 100, {"units": "%"})
    spectra = LIST.assign_coords(wavelength=um).assign(reflectance=percent)
    found = read_spectra(saved(spectra))
    assert_array_equal(found.wavelength, [410, 570, 580, 700])
    np.testing.assert_allclose(found.reflectance, GAPS, rtol=1e-15)
    assert found.reflectance.units == "1"
    assert found.wavelength.units == "nm"


def test_the_units_are_the_scale(saved):
    path = saved(LIST)
    assert read_spectra(path, scale="fraction").sizes["record"] == 3
    with pytest.raises(DataError, match=r"is written as 1, and .* it is 100 was given"):
        read_spectra(path, scale="percent")


def test_without_units_the_caller_may_say(saved):
    bare = LIST.copy()
    bare["reflectance"] = (("record", "wavelength"), GAPS * 100)
    path = saved(bare)
    with pytest.raises(DataError, match=r"above 1.5; if .* say --scale percent"):
        read_spectra(path)
    np.testing.assert_allclose(
        read_spectra(path, scale="percent").reflectance, GAPS, rtol=1e-15
    )


def test_records_without_labels_are_numbered(saved):
    bare = LIST.drop_vars("label").assign_coords(record=[4, 5, 9])
    assert read_spectra(saved(bare)).label.values.tolist() == [
        "record 4",
        "record 5",
        "record 9",
    ]


def test_packed_integers_are_unpacked(tmp_path):
    path = tmp_path / "hand.nc"
    CUBE.to_netcdf(
        path,
        engine="h5netcdf",
        encoding={
            "reflectance": {"dtype": "i2", "scale_factor": 1e-4, "_FillValue": -9999}
        },
    )
    np.testing.assert_allclose(
        read_spectra(path).reflectance, CUBE.reflectance, rtol=0, atol=0.51e-4
    )


def test_a_fit_is_not_read_as_a_measurement(saved):
    """Its file has a reflectance too: the model's body reflectance."""
    nm = np.arange(400, 701, 10)
    model = skin_model(site="cheek", specular="excluded")
    fit = fit_skin(model.measured([0.1, 8e-3, 4e-3], nm), nm, model)
    path = saved(fit.to_xarray())
    with pytest.raises(
        DataError, match=r"holds a fit, .* file of spectra that was fit"
    ):
        read_spectra(path)


REFUSED = {
    "no reflectance": (
        LIST.rename(reflectance="radiance"),
        "its variables are radiance",
    ),
    "nothing": (xarray.Dataset(), "its variables are none"),
    "other dims": (
        LIST.rename(record="x"),
        "dimensions x, wavelength; expected record",
    ),
    "one spectrum": (LIST.isel(record=0), "dimensions wavelength; expected"),
    "no wavelength": (LIST.drop_vars("wavelength"), "no coordinate wavelength"),
    "words": (LIST.assign_coords(wavelength=list("abcd")), "no coordinate wavelength"),
    "no numbers": (
        LIST.assign(reflectance=LIST.reflectance.astype(str)),
        "not real num",
    ),
    "complex": (
        LIST.assign(reflectance=LIST.reflectance * 1j),
        "not real numbers|whole",
    ),
    "no records": (LIST.isel(record=[]), "no spectra in it"),
    "negative": (LIST.assign(reflectance=-LIST.reflectance), "is negative; check the"),
    "infinite": (
        LIST.assign(reflectance=LIST.reflectance * np.inf),
        "inf is not finite",
    ),
    "descending": (LIST.isel(wavelength=[1, 0]), "400.25 nm follows 555.123 nm"),
    "in metres": (
        LIST.assign_coords(wavelength=LIST.wavelength.assign_attrs(units="m")),
        "wavelengths are in 'm'; expected nanometers",
    ),
    "in volts": (
        LIST.assign(reflectance=LIST.reflectance.assign_attrs(units="V")),
        "has the units 'v'; expected '1' or '%'",
    ),
    "misspelt": (LIST.assign_attrs(specular="some"), "unknown specular"),
    "two": (LIST.assign_attrs(specular=np.array([0.1, 0.2])), "specular"),
    "label": (LIST.drop_vars("label").assign_coords(label="x"), "not along record"),
    "infinite pixel": (CUBE * np.float32(np.inf), "line 0, sample 0 is infinite"),
    "bright": (CUBE * 20, "values are above 1.5"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_every_refusal_names_the_file_and_the_fault(saved, what):
    dataset, told = REFUSED[what]
    if "reflectance" in dataset:
        dataset.reflectance.attrs.setdefault("units", "1")
    path = saved(dataset)
    with pytest.raises(DataError, match=f"^{re.escape(str(path))}.*{told}"):
        read_spectra(path)


def test_files_of_other_kinds_are_named(tmp_path):
    path = tmp_path / "hand.nc"
    path.write_bytes(b"CDF\x01" + bytes(40))
    with pytest.raises(DataError, match=r"netCDF's classic form; .*\(nccopy -k nc4"):
        read_spectra(path)
    path.write_text("wavelength,A\n400,0.1\n")
    with pytest.raises(DataError, match="not a whole netCDF-4 file"):
        read_spectra(path)


def test_a_cut_off_file_is_refused(tmp_path):
    path = write_spectra(tmp_path / "hand.nc", LIST)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(DataError, match="not a whole netCDF-4 file"):
        read_spectra(path)


def test_a_few_bytes_that_declare_terabytes_are_refused(tmp_path):
    path = tmp_path / "bomb.nc"
    with h5py.File(path, "w") as file:
        shape = {"line": 10**6, "sample": 10**6, "wavelength": 61}
        for name, size in shape.items():
            file.create_dataset(name, (size,), "f4", chunks=(61,)).make_scale(name)
        bomb = file.create_dataset(
            "reflectance", tuple(shape.values()), "f4", chunks=(10, 10, 61)
        )
        for axis, name in enumerate(shape):
            bomb.dims[axis].attach_scale(file[name])
    with pytest.raises(DataError, match=r"declares .* MiB of values and has"):
        read_spectra(path)


@pytest.mark.parametrize("value", [None, {"a": 1}, object()])
def test_an_attribute_that_netcdf_cannot_hold_is_refused(tmp_path, value):
    with pytest.raises(ArgumentError, match=r"hand\.nc: cannot be written"):
        write_spectra(tmp_path / "hand.nc", LIST.assign_attrs(thing=value))
    assert not list(tmp_path.iterdir())
