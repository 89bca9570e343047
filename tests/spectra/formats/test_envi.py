"""ENVI cubes: bytes laid out by hand, and the spectral package, are the oracles."""

import re
import tracemalloc

import numpy as np
import pytest
import spectral.io.envi
import xarray
from numpy.testing import assert_allclose, assert_array_equal
from spectra_tables import skin_like, spectra_cube, spectra_list

from skinviz import ArgumentError, DataError, read_spectra, write_spectra

LINES, SAMPLES, NM = 3, 4, [400.0, 500.0, 632.8, 700.0, 900.0]
VALUES = skin_like(LINES, SAMPLES, len(NM))
ORDER = {"bsq": "bls", "bil": "lbs", "bip": "lsb"}
CODES = {"u1": 1, "i2": 2, "i4": 3, "f4": 4, "f8": 5, "u2": 12, "u4": 13, "i8": 14}


def header(**changes):
    """Return the text of a header; a field changed to None is left out."""
    fields = {
        "samples": SAMPLES,
        "lines": LINES,
        "bands": len(NM),
        "header_offset": 0,
        "file_type": "ENVI Standard",
        "data_type": 4,
        "interleave": "bip",
        "byte_order": 0,
        "wavelength_units": "Nanometers",
        "wavelength": "{" + ",\n ".join(map(str, NM)) + "}",
    } | changes
    told = {key.replace("_", " "): v for key, v in fields.items() if v is not None}
    return "ENVI\n" + "".join(f"{key} = {value}\n" for key, value in told.items())


@pytest.fixture
def cube(tmp_path):
    """Return a function that lays a cube out in bytes and returns its header."""

    def write(
        values=VALUES, dtype="<f4", interleave="bip", *, raw="hand.img", **changes
    ):
        axes = ["lsb".index(axis) for axis in ORDER[interleave]]
        stored = np.ascontiguousarray(np.transpose(values, axes)).astype(dtype)
        offset = bytes(changes.get("header_offset", 0))
        (tmp_path / raw).write_bytes(offset + stored.tobytes())
        path = tmp_path / "hand.hdr"
        order = {"byte_order": int(dtype[0] == ">"), "data_type": CODES[dtype[1:]]}
        changes = {"interleave": interleave, **order, **changes}
        path.write_text(header(**changes))
        return path

    return write


def read_by_spectral(path):
    """Return a cube (line, sample, band) as the spectral package reads it."""
    image = spectral.io.envi.open(str(path))
    return np.array(image.open_memmap(interleave="bip")) / image.scale_factor


# --- reading -------------------------------------------------------------------


@pytest.mark.parametrize("interleave", ORDER)
@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("kind", CODES)
def test_every_layout_is_read_as_spectral_reads_it(cube, interleave, order, kind):
    whole = kind[0] in "ui"
    full = {"u1": 250, "i2": 10000}.get(kind, 60000) if whole else 1
    values = np.round(VALUES * full) if whole else VALUES
    path = cube(
        values,
        order + kind,
        interleave,
        reflectance_scale_factor=full if whole else None,
        header_offset=7,
    )
    found = read_spectra(path).reflectance
    assert found.dims == ("line", "sample", "wavelength")
    exact = np.float32 if kind in ("u1", "i2", "u2", "f4") else np.float64
    assert found.dtype == exact
    assert found.values.dtype.isnative
    assert_array_equal(found, (values.astype(exact) / exact(full)))
    assert_allclose(found, read_by_spectral(path), rtol=1e-7)


def test_every_part_of_the_header_is_read(cube):
    path = cube(
        description="{left\n hand }",
        sensor_type="Specim IQ",
        acquisition_time="2024-05-06T07:08:09Z",
        geometry="0/45",
        specular=0.03,
        default_bands="{3, 2, 1}",
    )
    path.write_text(path.read_text().replace("ENVI\n", "ENVI\n; a remark = 1\n\n"))
    found = read_spectra(path)
    assert_array_equal(found.wavelength, NM)
    assert found.attrs == {
        "source": str(path),
        "specular": 0.03,
        "geometry": "0/45",
        "instrument": "Specim IQ",
        "date": "2024-05-06T07:08:09Z",
        "comment": "left hand",
    }


def test_names_in_capitals_and_windows_text_do_not_matter(cube):
    path = cube()
    text = path.read_text().replace("wavelength units", "Wavelength Units")
    text = text.replace("bip", "BIP") + "description = {20 °C}\n"
    path.write_bytes(text.replace("\n", "\r\n").encode("latin-1"))
    assert read_spectra(path).comment == "20 °C"


@pytest.mark.parametrize("unit", ["Micrometers", "um", "µm", "microns"])
def test_micrometres_are_converted_without_noise(cube, unit):
    path = cube(wavelength_units=unit, wavelength="{0.41, 0.57, 0.58, 0.7, 0.9}")
    assert_array_equal(read_spectra(path).wavelength, [410, 570, 580, 700, 900])


@pytest.mark.parametrize(
    "raw", ["hand", "hand.bip", "hand.IMG", "hand.dat", "hand.raw"]
)
def test_the_raw_file_is_found_by_the_headers_name(cube, raw):
    assert_allclose(read_spectra(cube(raw=raw)).reflectance, VALUES, rtol=1e-7)


def test_a_header_named_after_the_whole_raw_file(cube, tmp_path):
    cube().rename(tmp_path / "hand.img.hdr")
    assert read_spectra(tmp_path / "hand.img.hdr").sizes["line"] == LINES


@pytest.mark.parametrize(
    ("dtype", "mark", "said"),
    [
        ("<i2", -9999, "-9999"),
        ("<u1", 0, "0"),
        ("<f4", -1.1, "-1.1"),
        (">f4", np.float32(-3.4028235e38), "-3.4028234663852886e+38"),
        ("<f8", -1e300, "-1e300"),
        ("<f4", np.nan, "nan"),
    ],
)
def test_the_ignored_value_becomes_nan(cube, dtype, mark, said):
    values = np.round(VALUES * 200)
    values[1, 2, 3] = values[0, 0] = mark
    path = cube(values, dtype, data_ignore_value=said, reflectance_scale_factor=200)
    found = read_spectra(path).reflectance.values
    assert np.isnan(found[1, 2, 3])
    assert np.isnan(found[0, 0]).all()
    assert np.isnan(found).sum() == 1 + len(NM)


def test_bad_bands_become_nan_and_stay_on_the_grid(cube):
    found = read_spectra(cube(bbl="{1, 0, 1, 1.0, 0}")).reflectance.values
    assert np.isnan(found[..., [1, 4]]).all()
    assert_allclose(found[..., [0, 2, 3]], VALUES[..., [0, 2, 3]], rtol=1e-7)


def test_single_dark_and_bright_pixels_stay_as_they_are(cube):
    """Noise and highlights: a fit refuses them one by one."""
    values = VALUES.copy()
    values[0, 0, 0], values[1, 1, 1] = -0.01, 1.9
    assert_allclose(read_spectra(cube(values)).reflectance, values, rtol=1e-7)


def test_the_memory_is_that_of_the_cube(cube):
    """Beside the cube itself there are only blocks of it."""
    shape = (256, 256, 128)
    values = np.full(shape, 5000, dtype=np.int16)
    path = cube(
        values,
        "<i2",
        "bsq",
        lines=256,
        samples=256,
        bands=128,
        wavelength="{" + ",".join(str(400 + 2 * i) for i in range(128)) + "}",
        reflectance_scale_factor=10000,
        data_ignore_value=-1,
    )
    tracemalloc.start()
    found = read_spectra(path).reflectance
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert (found == np.float32(0.5)).all()
    assert peak < 1.5 * found.nbytes


# --- writing -------------------------------------------------------------------

CUBE = spectra_cube(
    skin_like(3, 4, 5, seed=2, dtype=np.float32),
    NM,
    specular="included",
    geometry="d/8",
    instrument="Specim IQ",
    date="2024-05-06",
    comment="the back of a hand; 20 °C",
)


def test_what_is_written_is_read(tmp_path):
    spectra = CUBE.copy(deep=True)
    spectra.reflectance[1, 2, 3] = np.nan
    path = write_spectra(tmp_path / "new" / "hand.hdr", spectra)
    assert sorted(p.name for p in path.parent.iterdir()) == ["hand.bip", "hand.hdr"]
    expected = spectra.assign_attrs(source=str(path))
    xarray.testing.assert_identical(read_spectra(path), expected)


def test_the_spectral_package_reads_what_we_write(tmp_path):
    path = write_spectra(tmp_path / "hand.hdr", CUBE)
    image = spectral.io.envi.open(str(path))
    assert image.shape == (3, 4, 5)
    assert image.scale_factor == 1
    assert image.bands.centers == NM
    assert image.bands.band_unit == "Nanometers"
    assert image.metadata["description"] == CUBE.comment
    assert_array_equal(read_by_spectral(path), CUBE.reflectance)


def test_any_order_of_axes_and_any_numbers_are_written(tmp_path):
    turned = CUBE.astype(float).transpose("wavelength", "sample", "line")
    found = read_spectra(write_spectra(tmp_path / "hand.hdr", turned)).reflectance
    assert found.dtype == np.float32
    assert_array_equal(found, CUBE.reflectance)


def test_a_cube_is_written_over_its_former_self(tmp_path):
    write_spectra(tmp_path / "hand.hdr", CUBE)
    smaller = CUBE.isel(line=[0])
    path = write_spectra(tmp_path / "hand.hdr", smaller)
    assert read_spectra(path).sizes["line"] == 1


REFUSED_TO_WRITE = {
    "a list": (
        spectra_list([[0.1, 0.2]]),
        r"cannot hold a list .*; write \.csv or \.nc",
    ),
    "a brace": (CUBE.assign_attrs(comment="{a}"), "has a brace"),
    "a line": (CUBE.assign_attrs(date="a\nbands = 9"), "line break or control"),
    "huge": (spectra_cube([[[0.1, 1e39]]], [400, 900]), "too large for float32"),
    "infinite": (spectra_cube([[[0.1, np.inf]]]), "line 0, sample 0 is infinite"),
    "per cent": (spectra_cube([[[10.0, 20]]]), "2 of 2 values are above 1.5"),
}


@pytest.mark.parametrize("what", REFUSED_TO_WRITE)
def test_what_cannot_be_held_is_not_written(tmp_path, what):
    spectra, told = REFUSED_TO_WRITE[what]
    with pytest.raises(ArgumentError, match=told):
        write_spectra(tmp_path / "hand.hdr", spectra)
    assert not list(tmp_path.iterdir())


def test_another_raw_file_is_not_left_to_be_mistaken(tmp_path, cube):
    path = cube()
    with pytest.raises(ArgumentError, match=r"hand\.img lies beside it"):
        write_spectra(path, CUBE)
    assert_allclose(read_spectra(path).reflectance, VALUES, rtol=1e-7)


def test_a_raw_file_without_a_header_is_not_overwritten(tmp_path):
    (tmp_path / "hand.bip").write_bytes(b"mine")
    with pytest.raises(ArgumentError, match=r"hand\.bip lies beside it and would be l"):
        write_spectra(tmp_path / "hand.hdr", CUBE)
    assert (tmp_path / "hand.bip").read_bytes() == b"mine"


def test_many_bands_are_written_on_lines_that_readers_take(tmp_path):
    wavelengths = np.linspace(380, 1000, 3001)
    cube = spectra_cube(np.full((1, 1, 3001), 0.5), wavelengths)
    path = write_spectra(tmp_path / "hand.hdr", cube)
    assert max(map(len, path.read_text().splitlines())) < 120
    assert_array_equal(read_spectra(path).wavelength, wavelengths)
    assert spectral.io.envi.open(str(path)).bands.centers == wavelengths.tolist()


# --- refusals ------------------------------------------------------------------

REFUSED = {
    "not ENVI": ("samples = 3\n", "the first line is not ENVI"),
    "binary": (b"ENVI\0\0", "not a text file; expected an ENVI header"),
    "open brace": (header(bbl="{1, 2"), "the brace after 'bbl' is open"),
    "library": (header(file_type="ENVI Spectral Library"), "'ENVI Spectral Library'"),
    "complex": (header(data_type=6), "'data type' is '6'; expected one of 1, 2"),
    "interleave": (header(interleave="bib"), "'interleave' is 'bib'; .* bip, bil, bsq"),
    "byte order": (header(byte_order=2), "'byte order' is '2'; expected one of 0, 1"),
    "short": (
        header(lines=LINES + 1),
        r"4 × 4 × 5 .* need 320 bytes.*hand\.img has 240",
    ),
    "long": (header(lines=LINES - 1), "need 160 bytes"),
    "offset": (header(header_offset=8), "after 8 need 248 bytes"),
    "no lines": (header(lines=0), "0 × 4 × 5 .* at least one"),
    "no bands": (header(bands=0), "at least one"),
    "negative": (header(lines=-3), "'lines' is '-3'; expected a whole number"),
    "a fraction": (header(lines=3.5), "expected a whole number"),
    "absurd": (header(lines=10**17, samples=10**17), "need 2"),
    "more absurd": (header(lines="9" * 5000), "expected a whole number"),
    "no unit": (header(wavelength_units=None), "'wavelength units = Nanometers'"),
    "no bands named": (header(wavelength=None), "says no 'wavelength'"),
    "wavenumbers": (header(wavelength_units="Wavenumber"), "are in 'Wavenumber'"),
    "too few": (header(wavelength="{400, 500}"), "has 2 values for 5 bands"),
    "a word": (header(wavelength="{a, 1, 2, 3, 4}"), "expected a number, found 'a'"),
    "descending": (header(wavelength="{700, 600, 500, 450, 400}"), "must ascend"),
    "micrometres": (header(wavelength="{.4, .5, .6, .7, .8}"), "expected in nm"),
    "factor 0": (header(reflectance_scale_factor=0), "expected a number above 0"),
    "factor": (header(reflectance_scale_factor="x"), "scale factor: expected a number"),
    "too large": (header(reflectance_scale_factor=1e4), "at most 1, .* where 10000"),
    "too small": (header(reflectance_scale_factor=1e-2), "60 of 60|48 of 48"),
    "gains": (header(data_gain_values="{2, 2, 2, 2, 2}"), "not applied yet"),
    "offsets": (header(data_offset_values="{1, 0, 0, 0, 0}"), "not applied yet"),
    "bad bands": (header(bbl="{1, 0, 2, 1, 1}"), "'bbl' has other values than 0"),
    "ignore": (header(data_ignore_value="none"), "ignore value: expected a number"),
    "misspelt": (header(specular="some"), "unknown specular"),
    **{
        f"no {name}": (header(**{name: None}), f"the header has no '{name}")
        for name in ("samples", "lines", "bands", "interleave")
    },
}


@pytest.mark.parametrize("what", REFUSED)
def test_every_refusal_names_the_file_and_the_fault(cube, what):
    text, told = REFUSED[what]
    path = cube()
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(DataError, match=f"^{re.escape(str(path))}.*{told}"):
        read_spectra(path)


def test_gains_that_do_nothing_do_nothing(cube):
    path = cube(data_gain_values="{1, 1, 1, 1, 1}", data_offset_values="{0,0,0,0,0}")
    assert_allclose(read_spectra(path).reflectance, VALUES, rtol=1e-7)


def test_an_infinite_pixel_is_named(cube):
    values = VALUES.copy()
    values[2, 1, 0] = np.inf
    with pytest.raises(DataError, match="line 2, sample 1 is infinite"):
        read_spectra(cube(values))


def test_integers_without_their_scale_are_refused(cube):
    path = cube(np.round(VALUES * 10000), "<i2")
    with pytest.raises(DataError, match=r"48 of 48 values are above 1.5"):
        read_spectra(path)


def test_the_factor_is_the_scale(cube):
    path = cube(VALUES * 100, reflectance_scale_factor=100)
    found = read_spectra(path, scale="percent").reflectance
    assert_allclose(found, VALUES, rtol=2e-7)
    with pytest.raises(DataError, match=r"is written as 100, and .* it is 1 was given"):
        read_spectra(path, scale="fraction")


def test_a_raw_file_that_cannot_be_mapped_is_refused(cube, monkeypatch):
    def full(*_):
        raise OSError(12, "Cannot allocate memory")

    monkeypatch.setattr("numpy.memmap", full)
    with pytest.raises(DataError, match=r"hand\.img: cannot be read: .*allocate"):
        read_spectra(cube())


def test_a_cube_larger_than_the_memory_is_refused(cube, monkeypatch):
    zeros = np.zeros

    def full(shape, dtype=float):
        if shape == VALUES.shape:
            raise MemoryError
        return zeros(shape, dtype)

    monkeypatch.setattr("numpy.zeros", full)
    with pytest.raises(DataError, match="the cube does not fit into the memory"):
        read_spectra(cube())


def test_a_header_alone_and_two_raw_files_are_refused(cube, tmp_path):
    path = cube()
    (tmp_path / "hand.bil").write_bytes((tmp_path / "hand.img").read_bytes())
    with pytest.raises(
        DataError, match=r"hand\.bil, hand\.img may all be its raw file"
    ):
        read_spectra(path)
    (tmp_path / "hand.bil").unlink()
    (tmp_path / "hand.img").unlink()
    with pytest.raises(
        DataError, match=r"no raw file beside it; expected hand alone or"
    ):
        read_spectra(path)


@pytest.mark.parametrize("raw", ["hand.img", "hand.bip", "hand.raw"])
def test_a_raw_file_asks_for_its_header(cube, tmp_path, raw):
    cube(raw=raw)
    with pytest.raises(DataError, match=r"give hand\.hdr, and write the header if"):
        read_spectra(tmp_path / raw)
    with pytest.raises(ArgumentError, match=r"give hand\.hdr"):
        write_spectra(tmp_path / raw, CUBE)
