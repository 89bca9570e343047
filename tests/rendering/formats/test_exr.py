"""EXR files: Mitsuba's reader, OpenEXR read anew, and colour-science's names of
bands are the oracles."""

import json
import re
import struct
import tracemalloc

import numpy as np
import OpenEXR
import pytest
from pictures import METADATA, NM, MadePicture

from skinviz import ArgumentError
from skinviz.rendering.files import write_picture
from skinviz.rendering.formats import exr
from skinviz.spectra.colorimetry import xyz_to_linear_srgb

NAMES = ["S0.400,000000nm", "S0.512,500000nm", "S0.632,800000nm", "S0.700,000000nm"]


@pytest.fixture(scope="module")
def bitmap():
    """Return a function that reads a file as Mitsuba does."""
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    return lambda file: mitsuba.Bitmap(str(file))


@pytest.mark.parametrize("size", [(7, 5), (1, 1), (1, 300), (300, 1), (129, 65)])
def test_mitsuba_reads_every_value_bit_by_bit(tmp_path, bitmap, size):
    picture = MadePicture(size)
    found = bitmap(write_picture(tmp_path / "a.exr", picture))
    values = np.array(found)
    assert values.dtype == np.float32
    assert [channel.name for channel in found.struct_()] == [*"RGB", *NAMES]
    np.testing.assert_array_equal(values[..., 3:], picture.radiance)
    linear = xyz_to_linear_srgb(picture.xyz).astype(np.float32)
    np.testing.assert_array_equal(values[..., :3], linear)


def test_mitsuba_reads_the_metadata(tmp_path, bitmap):
    found = bitmap(write_picture(tmp_path / "a.exr", MadePicture())).metadata()
    assert found["spectralLayoutVersion"] == "1.0"
    assert found["emissiveUnits"] == "W.m^-2.sr^-1"
    assert found["software"].startswith("skinviz ")
    assert found["comments"].startswith("Linke Hand, 60°/60°; spectral radiance [1 / w")
    assert json.loads(found["skinviz"]) == METADATA


def test_openexr_reads_it_anew(tmp_path):
    picture = MadePicture()
    file = write_picture(tmp_path / "a.exr", picture)
    with OpenEXR.File(str(file), separate_channels=True) as whole:
        channels, header = whole.channels(), whole.header()
        for i, name in enumerate(NAMES):
            assert channels[name].pixels.dtype == np.float32
            np.testing.assert_array_equal(
                channels[name].pixels, picture.radiance[..., i]
            )
        rec709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
        np.testing.assert_allclose(header["chromaticities"], rec709, rtol=1e-6)


def test_the_bytes_of_the_header_are_those_of_the_layout(tmp_path):
    """Attributes as the file format has them: name, type, size, value."""
    content = write_picture(tmp_path / "a.exr", MadePicture()).read_bytes()
    assert content[:4] == b"\x76\x2f\x31\x01"
    version, flags = content[4], int.from_bytes(content[5:8], "little")
    assert (version, flags) == (2, 0)  # scan lines, one part, short names
    for name, value in [
        (b"spectralLayoutVersion", b"1.0"),
        (b"emissiveUnits", b"W.m^-2.sr^-1"),
    ]:
        attribute = name + b"\0string\0" + struct.pack("<I", len(value)) + value
        assert content.count(attribute) == 1
    for name in NAMES:
        channel = name.encode() + b"\0" + struct.pack("<IIII", 2, 0, 1, 1)  # float32
        assert content.count(channel) == 1


def test_the_names_of_bands_are_read_by_colour_science():
    from colour.io.fichet2021 import PATTERN_FICHET2021, match_groups_to_nm

    wavelengths = [*NM, 380 + 1 / 3, 1000.0, 2500.125, 0.1, np.nextafter(550, 600)]
    for nm in wavelengths:
        name = exr.channel_name(nm)
        found = re.fullmatch(rf"S0\.{PATTERN_FICHET2021}", name)
        number, _, multiplier, units = found.groups()
        assert match_groups_to_nm(number, multiplier, units) == pytest.approx(
            nm, rel=1e-15
        )
        assert float(number.replace(",", ".")) == nm
        assert len(name) <= 31  # the longest that old readers take


def test_bands_of_every_number_of_digits_come_back_in_their_order(tmp_path):
    """The format sorts channels by name, and so 1000 nm before 400."""
    picture = MadePicture(wavelengths=np.array([99.5, 400.0, 1000.0]))
    file = write_picture(tmp_path / "a.exr", picture)
    with OpenEXR.File(str(file), separate_channels=True) as whole:
        for i, nm in enumerate(picture.wavelengths):
            pixels = whole.channels()[exr.channel_name(nm)].pixels
            np.testing.assert_array_equal(pixels, picture.radiance[..., i])


def test_values_beyond_half_floats_stay(tmp_path):
    """Highlights, and the smallest float32."""
    picture = MadePicture((3, 1))
    picture.radiance[0, :, 0] = (1e30, 65505.0, 1e-45)
    picture.xyz[0, 0] = (1e30, 1e30, 1e30)
    file = write_picture(tmp_path / "a.exr", picture)
    with OpenEXR.File(str(file), separate_channels=True) as whole:
        channels = whole.channels()
        np.testing.assert_array_equal(
            channels[NAMES[0]].pixels, picture.radiance[..., 0]
        )
        assert channels["G"].pixels[0, 0] == pytest.approx(0.9484e30, rel=1e-5)


def test_what_is_too_large_for_memory_names_the_format_that_is_streamed(tmp_path):
    class Large:
        size = (8192, 8192)
        wavelengths = np.linspace(400, 700, 61)
        metadata = METADATA

    message = r"64 channels of 8192 × 8192 pixels are 16\.0 GiB; .* write \.hdr \(ENVI"
    with pytest.raises(ArgumentError, match=message):
        write_picture(tmp_path / "a.exr", Large())
    assert not list(tmp_path.iterdir())


def test_the_memory_is_that_of_the_channels(tmp_path):
    picture = MadePicture((256, 256), np.linspace(400, 700, 61))
    size = picture.radiance.nbytes + picture.xyz.nbytes
    tracemalloc.start()
    write_picture(tmp_path / "a.exr", picture)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1.2 * size


def test_the_setting_of_the_process_is_left_as_it_was(tmp_path):
    before = OpenEXR.global_thread_count()
    OpenEXR.set_global_thread_count(1)
    try:
        write_picture(tmp_path / "a.exr", MadePicture())
        assert OpenEXR.global_thread_count() == 1
    finally:
        OpenEXR.set_global_thread_count(before)
