"""TM-27-14: colour-science reads what we write and we read what it writes."""

import re

import numpy as np
import pytest
import xarray
from numpy.testing import assert_allclose, assert_array_equal
from spectra_tables import skin_like, spectra_list

from skinviz import ArgumentError, DataError, read_spectra, write_spectra

SPACE = "http://www.ies.org/iestm2714"
WHOLE = f"""<IESTM2714 xmlns="{SPACE}" version="1.0">
  <Header>
    <Description>left
      cheek</Description>
    <MeasurementEquipment>PR-655</MeasurementEquipment>
    <ReportDate>2024-05-06T07:08:09</ReportDate>
    <Comments>polariser in
      specular: 0.03
      warm</Comments>
  </Header>
  <SpectralDistribution>
    <SpectralQuantity>reflectance</SpectralQuantity>
    <ReflectionGeometry>45x:0</ReflectionGeometry>
    <SpectralData wavelength="400.0">0.1</SpectralData>
    <SpectralData wavelength="500.5">0.3</SpectralData>
    <SpectralData wavelength="600">5e-1</SpectralData>
  </SpectralDistribution>
</IESTM2714>
"""
SPECTRUM = spectra_list(
    skin_like(1, 5),
    ["left cheek <1> & 'Ä'"],
    [400, 410.25, 555.123456789, 632.8, 700],
    geometry="di:8",
    specular="included",
    instrument="CM-700d",
    date="2024-05-06",
    comment="third of three",
)


@pytest.fixture
def written(tmp_path):
    """Return a function that writes text to a file and returns its path."""

    def write(text, encoding="utf-8"):
        path = tmp_path / "hand.spdx"
        path.write_bytes(text.encode(encoding))
        return path

    return write


def test_every_part_of_a_file_is_read(written):
    path = written(WHOLE)
    found = read_spectra(path)
    assert_array_equal(found.reflectance, [[0.1, 0.3, 0.5]])
    assert_array_equal(found.wavelength, [400, 500.5, 600])
    assert found.label.values.tolist() == ["left cheek"]
    assert found.attrs == {
        "source": str(path),
        "geometry": "45x:0",
        "specular": 0.03,
        "instrument": "PR-655",
        "date": "2024-05-06T07:08:09",
        "comment": "polariser in warm",
    }


def test_a_file_that_says_little_is_named_after_itself(written):
    text = re.sub(r"(?s)<Header>.*</Header>", "", WHOLE)
    path = written(re.sub("<ReflectionGeometry>.*\n", "", text))
    found = read_spectra(path, specular="excluded")
    assert found.label.values.tolist() == ["hand"]
    assert found.attrs == {"source": str(path), "specular": "excluded"}


@pytest.mark.parametrize(
    ("geometry", "specular"),
    [
        ("di:8", "included"),
        ("8:di", "included"),
        ("de:8", "excluded"),
        ("8:de", "excluded"),
        ("45a:0", "excluded"),
        ("0:45x", "excluded"),
    ],
)
def test_the_standards_geometries_say_how_the_surface_was_measured(
    written, geometry, specular
):
    text = WHOLE.replace("45x:0", geometry).replace("specular: 0.03", "")
    assert read_spectra(written(text)).specular == specular
    other = {"included": "excluded", "excluded": "included"}[specular]
    with pytest.raises(DataError, match=f"is {specular}, and {other} was given"):
        read_spectra(written(text), specular=other)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_every_encoding_that_xml_declares(written, encoding):
    named = encoding.removesuffix("-sig")
    text = f'<?xml version="1.0" encoding="{named}"?>\n' + WHOLE.replace("warm", "wärm")
    found = read_spectra(written(text, encoding))
    assert found.comment == "polariser in wärm"
    assert_array_equal(found.reflectance, [[0.1, 0.3, 0.5]])


def test_what_is_written_is_read(tmp_path):
    path = write_spectra(tmp_path / "hand.spdx", SPECTRUM)
    found = read_spectra(path)
    expected = SPECTRUM.assign_attrs(source=str(path))
    xarray.testing.assert_identical(found, expected)


@pytest.mark.parametrize(
    "attributes",
    [
        {},
        {"geometry": "d/8, beam 3 mm", "specular": "excluded"},
        {"geometry": "di:8", "specular": 0.03, "comment": "note: a thing"},
        {"specular": "included"},
        {"geometry": "d:0"},
    ],
)
def test_what_the_standard_has_no_word_for_comes_back_too(tmp_path, attributes):
    path = write_spectra(
        tmp_path / "hand.spdx", spectra_list([[0.1, 0.2]], **attributes)
    )
    assert read_spectra(path).attrs == {"source": str(path), **attributes}


# --- the independent reader and writer -----------------------------------------


def test_colour_science_reads_what_we_write(tmp_path, colour):
    path = write_spectra(tmp_path / "hand.spdx", SPECTRUM)
    found = colour.SpectralDistribution_IESTM2714(str(path)).read()
    assert_array_equal(found.wavelengths, SPECTRUM.wavelength)
    assert_array_equal(found.values, SPECTRUM.reflectance[0])
    assert found.spectral_quantity == "reflectance"
    assert found.reflection_geometry == "di:8"
    assert found.header.description == SPECTRUM.label.values[0]
    assert found.header.measurement_equipment == "CM-700d"
    assert found.header.comments == "third of three"
    assert re.fullmatch(
        r"\d{4}-\d\d-\d\dT[\d:]{8}", found.header.document_creation_date
    )


@pytest.mark.parametrize("quantity", ["reflectance", "R-Factor"])
def test_we_read_what_colour_science_writes(tmp_path, colour, quantity):
    path = tmp_path / "theirs.spdx"
    nm, values = np.arange(400.0, 701, 12.5), skin_like(25, seed=3)
    written = colour.SpectralDistribution_IESTM2714(
        str(path),
        spectral_quantity=quantity,
        reflection_geometry="de:8",
        data=dict(zip(nm, values, strict=True)),
    )
    written.header.description = "inner arm"
    assert written.write()
    found = read_spectra(path)
    assert_array_equal(found.wavelength, nm)
    assert_allclose(found.reflectance[0], values, rtol=0, atol=0.5e-12)  # as printed
    # Its "None" for what it was not told is not a word of the file.
    assert found.attrs == {
        "source": str(path),
        "geometry": "de:8",
        "specular": "excluded",
    }
    assert found.label.values.tolist() == ["inner arm"]


def test_colour_sciences_lamp_is_no_reflectance(tmp_path, colour):
    lamp = colour.SpectralDistribution_IESTM2714(
        str(tmp_path / "lamp.spdx"),
        spectral_quantity="relative",
        data={400: 0.1, 700: 0.2},
    )
    assert lamp.write()
    with pytest.raises(
        DataError, match=r"SpectralQuantity is 'relative'; .*reflectance"
    ):
        read_spectra(tmp_path / "lamp.spdx")


# --- refusals ------------------------------------------------------------------

LAUGHS = (
    '<!DOCTYPE x [<!ENTITY a "ha">'
    + "".join(
        f'<!ENTITY {c} "{f"&{b};" * 10}">'
        for b, c in zip("abcdefgh", "bcdefghi", strict=True)
    )
    + "]>"
)
REFUSED = {
    "laughs": (LAUGHS + WHOLE.replace("warm", "&i;"), "has a DOCTYPE"),
    "a file": (
        '<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>' + WHOLE,
        "has a DOCTYPE",
    ),
    "no XML": ("wavelength,A\n400,0.1\n", "not whole XML"),
    "cut off": (WHOLE[:500], "not whole XML"),
    "unknown encoding": (
        '<?xml version="1.0" encoding="klingon"?>' + WHOLE,
        "not whole",
    ),
    "another XML": ("<svg/>", "outermost element is 'svg'"),
    "no namespace": (WHOLE.replace(f' xmlns="{SPACE}"', ""), "in the namespace"),
    "two": (
        WHOLE.replace(
            "</IESTM2714>", "<SpectralDistribution></SpectralDistribution></IESTM2714>"
        ),
        "2 elements SpectralDistribution",
    ),
    "none": (f'<IESTM2714 xmlns="{SPACE}"/>', "0 elements SpectralDistribution"),
    "transmittance": (
        WHOLE.replace(">reflectance", ">transmittance"),
        "'transmittance'",
    ),
    "flux": (
        WHOLE.replace(">reflectance", ">flux"),
        "'flux'; spectra of reflectance or",
    ),
    "no quantity": (re.sub("<SpectralQ.*\n", "", WHOLE), "SpectralQuantity is ''"),
    "no bands": (re.sub("<SpectralData.*\n", "", WHOLE), "no element SpectralData"),
    "no value": (WHOLE.replace(">0.3<", "><"), "band 2: .* found an empty cell"),
    "a word": (WHOLE.replace(">0.3<", ">dark<"), "band 2: .* found 'dark'"),
    "a comma": (WHOLE.replace(">0.3<", ">0,3<"), "write decimal points"),
    "NaN": (
        WHOLE.replace(">0.3<", ">nan<"),
        "'left cheek' at 500.5 nm: nan is not fin",
    ),
    "no wavelength": (WHOLE.replace(' wavelength="600"', ""), "wavelength of band 3"),
    "NaN wavelength": (WHOLE.replace('"600"', '"nan"'), "wavelength is not a finite"),
    "not ascending": (WHOLE.replace('"600"', '"450"'), "450 nm follows 500.5 nm"),
    "per cent": (WHOLE.replace(">0.3<", ">30<"), "30 is above 1.5, and the file decl"),
    "misspelt": (WHOLE.replace("specular: 0.03", "specular: some"), "unknown specular"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_every_refusal_names_the_file_and_the_fault(written, what):
    text, told = REFUSED[what]
    path = written(text)
    with pytest.raises(DataError, match=f"^{re.escape(str(path))}.*{told}"):
        read_spectra(path)


def test_entities_are_refused_in_any_encoding_of_xml(written):
    text = f'<?xml version="1.0" encoding="utf-16"?>{LAUGHS}{WHOLE}'
    with pytest.raises(DataError, match="has a DOCTYPE"):
        read_spectra(written(text, "utf-16"))


def test_a_huge_file_is_refused_before_it_is_parsed(written):
    path = written(WHOLE + " " * 2**22)
    with pytest.raises(DataError, match="less than 4 MiB"):
        read_spectra(path)


def test_the_standards_scale_is_not_to_be_argued_with(written):
    assert read_spectra(written(WHOLE), scale="fraction").sizes["record"] == 1
    with pytest.raises(DataError, match=r"is written as 1, and .* it is 100 was given"):
        read_spectra(written(WHOLE), scale="percent")


def test_two_spectra_are_two_files(tmp_path):
    with pytest.raises(ArgumentError, match=r"one spectrum, 2 were .* or all to \.csv"):
        write_spectra(tmp_path / "hand.spdx", spectra_list(skin_like(2, 3)))
    assert not list(tmp_path.iterdir())
