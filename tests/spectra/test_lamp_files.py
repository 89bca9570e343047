"""Measured lamps: the same light from every format, and one refusal for the rest."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from spectra_tables import skin_like, spectra_list

from skinviz import DataError, SkinvizError, read_spectra, write_spectra
from skinviz.spectra.illuminants import illuminant_spd, read_illuminant

NM, POWER = [400.0, 500.0, 632.8, 700.0], [0.0, 3e-3, 12.5, 1e-9]
SPACE = "http://www.ies.org/iestm2714"
SPDX = f"""<IESTM2714 xmlns="{SPACE}" version="1.0">
  <Header><Description>ceiling</Description></Header>
  <SpectralDistribution>
    <SpectralQuantity>irradiance</SpectralQuantity>
    <SpectralData wavelength="400">0</SpectralData>
    <SpectralData wavelength="500">3e-3</SpectralData>
    <SpectralData wavelength="632.8">12.5</SpectralData>
    <SpectralData wavelength="700">1e-9</SpectralData>
  </SpectralDistribution>
</IESTM2714>
"""
ARGYLL = """SPECT

DESCRIPTOR "Argyll Spectral power/reflectance information"
KEYWORD "MEAS_TYPE"
MEAS_TYPE "EMISSION"
KEYWORD "SPECTRAL_BANDS"
SPECTRAL_BANDS "4"
KEYWORD "SPECTRAL_START_NM"
SPECTRAL_START_NM "380.000000"
KEYWORD "SPECTRAL_END_NM"
SPECTRAL_END_NM "390.000000"
KEYWORD "SPECTRAL_NORM"
SPECTRAL_NORM "1.000000"
NUMBER_OF_FIELDS 4
BEGIN_DATA_FORMAT
SPEC_380 SPEC_383 SPEC_387 SPEC_390
END_DATA_FORMAT
NUMBER_OF_SETS 1
BEGIN_DATA
1.5 0.25 30 60
END_DATA
"""
CGATS = """CGATS.17
BEGIN_DATA_FORMAT
SAMPLE_ID nm400 nm500 nm632.8 nm700
END_DATA_FORMAT
BEGIN_DATA
lamp 0 3e-3 12.5 1e-9
END_DATA
"""
DOWN = "wavelength_nm,lamp\n400,0\n500,3e-3\n632.8,12.5\n700,1e-9\n"
BARE = DOWN.partition("\n")[2]
ACROSS = "lamp,400,500,632.8,700\nceiling,0,3e-3,12.5,1e-9\n"
FILES = {
    "down.csv": DOWN,
    "bare.csv": BARE,
    "semicolons.csv": BARE.replace(",", ";"),
    "across.csv": ACROSS,
    "noted.csv": "# instrument: PR-655\n# unit: W/m2/nm\n" + DOWN,
    "down.tsv": DOWN.replace(",", "\t"),
    "lamp.spdx": SPDX,
    "lamp.cgats": CGATS,
    "lamp.TXT": CGATS,
}


@pytest.fixture
def written(tmp_path):
    """Return a function that writes a file and returns its path."""

    def write(content, name="lamp.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


@pytest.mark.parametrize("name", FILES)
def test_a_lamp_is_the_same_in_every_format(written, name):
    lamp = read_illuminant(written(FILES[name], name))
    assert_array_equal(lamp.wavelengths, NM)
    assert_array_equal(lamp.power, POWER)
    assert lamp.name == name


def test_argylls_lamps_are_read_with_their_true_wavelengths(written):
    lamp = read_illuminant(written(ARGYLL, "lamp.sp"))
    assert_allclose(lamp.wavelengths, [380, 380 + 10 / 3, 380 + 20 / 3, 390])
    assert_array_equal(lamp.power, [1.5, 0.25, 30, 60])


def test_colour_sciences_file_of_a_lamp_is_read(colour, tmp_path):
    path = str(tmp_path / "a.spdx")
    nm = np.arange(380.0, 781.0, 5.0)
    spd = illuminant_spd("A", nm)
    written = colour.SpectralDistribution_IESTM2714(
        path, spectral_quantity="radiance", data=dict(zip(nm, spd, strict=True))
    )
    assert written.write()
    lamp = read_illuminant(path)
    assert_array_equal(lamp.wavelengths, nm)
    assert_array_equal(lamp.power, spd)


@pytest.mark.parametrize("unit", [1e-30, 1e30])
@pytest.mark.parametrize("suffix", ["csv", "spdx"])
def test_power_may_have_any_unit(written, unit, suffix):
    text = {"csv": DOWN, "spdx": SPDX}[suffix]
    scaled = text.replace("12.5", repr(12.5 * unit)).replace("3e-3", repr(3e-3 * unit))
    lamp = read_illuminant(written(scaled.replace("1e-9", "0"), f"lamp.{suffix}"))
    assert_allclose(lamp.power, np.array([0, 3e-3, 12.5, 0]) * unit, rtol=1e-15)


@pytest.mark.parametrize(
    "quantity", ["flux", "intensity", "irradiance", "radiance", "exitance", "relative"]
)
def test_light_of_any_quantity_is_read(written, quantity):
    lamp = read_illuminant(
        written(SPDX.replace(">irradiance<", f">{quantity}<"), "a.spdx")
    )
    assert_array_equal(lamp.power, POWER)


@pytest.mark.parametrize("kind", ["EMISSION", "AMBIENT", "EMISSION_FLASH", "Emissive"])
def test_light_of_any_kind_is_read(written, kind):
    lamp = read_illuminant(written(ARGYLL.replace('"EMISSION"', f'"{kind}"'), "a.sp"))
    assert lamp.power.size == 4


# --- refusals ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "name", "told"),
    [
        (DOWN.replace("12.5", "-1"), "a.csv", "must be ≥ 0; it is -1 at 632.8 nm"),
        (DOWN.replace("12.5", "nan"), "a.csv", "must be finite"),
        (DOWN.replace("12.5", "inf"), "a.csv", "must be finite"),
        (DOWN.replace("12.5", "1e999"), "a.csv", "must be finite"),
        ("400,0\n500,0\n", "a.csv", "0 everywhere"),
        ("500,1\n400,1\n", "a.csv", "must ascend"),
        ("400,1\n400,1\n", "a.csv", "must ascend"),
        ("0.4,1\n0.7,1\n", "a.csv", "expected in nm"),
        ("nan,1\n500,1\n", "a.csv", "the wavelength is nan"),
        ("w,400,500\nlamp,1\n", "a.csv", "line 2: 2 cells"),
        ("400,1\n500,x\n", "a.csv", "expected a number"),
        ("wavelength_nm,a,b\n400,1,2\n", "a.csv", r"2 spectra \(a, b\), and a lamp is"),
        (
            "wavelength_nm," + ",".join("abcdefg") + "\n400" + ",1" * 7,
            "a.csv",
            r"7 spectra \(a, b, c, d, e \.\.\.\)",
        ),
        ("# only a comment\n", "a.csv", "no data"),
        (b"\xff\xfe\0", "a.csv", "not a text file"),
        ("# specular: included\n" + DOWN, "a.csv", "so it is a reflectance"),
        (SPDX.replace(">irradiance<", ">reflectance<"), "a.spdx", "'reflectance'; spe"),
        (SPDX.replace(">irradiance<", ">other<"), "a.spdx", "'other'; spectra of flux"),
        (SPDX[:-30], "a.spdx", "not whole XML"),
        (
            ARGYLL.replace('"EMISSION"', '"REFLECTIVE"'),
            "a.sp",
            "REFLECTIVE is no light",
        ),
        (ARGYLL.replace('"EMISSION"', '"TRANSMISSIVE"'), "a.sp", "is no light"),
        (CGATS.replace("lamp 0", "a 0 1 1 1\nb 0"), "a.cgats", r"2 spectra \(a, b\)"),
        ("no cgats", "a.txt", "BEGIN_DATA"),
        (DOWN, "a.nc", r"lamps are read from .csv, .tsv, .spdx, .*; '.nc' is none"),
        (DOWN, "lamp", "'no suffix' is none"),
        ("", "a.csv", "is empty"),
    ],
)
def test_what_is_no_lamp_is_refused_and_its_file_named(written, text, name, told):
    with pytest.raises(DataError, match=told) as caught:
        read_illuminant(written(text, name))
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_or_a_folder_is_refused(tmp_path):
    with pytest.raises(DataError, match="no such file"):
        read_illuminant(tmp_path / "none.csv")
    with pytest.raises(DataError, match="is a folder"):
        read_illuminant(tmp_path)


def test_a_lamp_is_no_reflectance(written):
    with pytest.raises(DataError, match="'irradiance'; spectra of reflectance"):
        read_spectra(written(SPDX, "a.spdx"))
    with pytest.raises(DataError, match="EMISSION is not reflectance"):
        read_spectra(written(ARGYLL, "a.cgats"), scale="fraction")


def test_a_measured_reflectance_is_no_lamp(tmp_path):
    skin = spectra_list(skin_like(1, 4), specular="excluded")
    for suffix in (".csv", ".spdx", ".cgats"):
        path = write_spectra(tmp_path / f"skin{suffix}", skin)
        with pytest.raises(DataError, match="reflectance"):
            read_illuminant(path)


@pytest.mark.parametrize("name", ["down.csv", "lamp.spdx", "lamp.cgats"])
def test_a_broken_file_is_read_or_refused(written, name):
    rng = np.random.default_rng(0)
    whole = FILES[name].encode()
    for _ in range(200):
        broken = bytearray(whole)
        for _ in range(rng.integers(1, 4)):
            at = int(rng.integers(len(broken)))
            broken[at : at + int(rng.integers(1, 9))] = rng.choice(
                [b"", b"nan", b"-", b"\xff", b"1e400", rng.bytes(3), b"\n", b","]
            )
        try:
            lamp = read_illuminant(written(bytes(broken), f"broken-{name}"))
        except SkinvizError:
            continue
        assert np.isfinite(lamp.power).all()
        assert (lamp.power >= 0).all()
