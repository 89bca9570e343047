"""TIFF files: tifffile and Pillow read them, with and without imagecodecs."""

import io
import json
import subprocess
import sys

import numpy as np
import pytest
import tifffile
from pictures import METADATA, MadePicture
from PIL import Image, ImageCms

from skinviz.rendering.files import write_picture


@pytest.mark.parametrize("size", [(7, 5), (1, 1), (1, 300), (300, 1), (1024, 70)])
@pytest.mark.parametrize("suffix", [".tif", ".tiff", ".TIF"])
def test_tifffile_reads_the_colours_bit_by_bit(tmp_path, size, suffix):
    picture = MadePicture(size)
    found = tifffile.imread(write_picture(tmp_path / f"a{suffix}", picture))
    assert found.dtype == np.uint16
    np.testing.assert_array_equal(found.reshape(picture.rgb16.shape), picture.rgb16)


def test_pillow_reads_the_upper_8_bits(tmp_path):
    """It has no 16-bit colour, and takes the upper byte."""
    picture = MadePicture()
    with Image.open(write_picture(tmp_path / "a.tif", picture)) as image:
        assert image.mode == "RGB"
        np.testing.assert_array_equal(np.asarray(image), picture.rgb16 >> 8)
        assert json.loads(image.tag_v2[270]) == METADATA


def test_the_tags_say_what_is_in_it(tmp_path):
    file = write_picture(tmp_path / "a.tif", MadePicture())
    with tifffile.TiffFile(file) as whole:
        assert len(whole.pages) == 1
        assert not whole.is_bigtiff
        tags = {tag.name: tag.value for tag in whole.pages[0].tags}
    assert tags["Software"].startswith("skinviz ")
    assert tags["PhotometricInterpretation"] == tifffile.PHOTOMETRIC.RGB
    assert tags["BitsPerSample"] == (16, 16, 16)
    assert tags["Compression"] == tifffile.COMPRESSION.ADOBE_DEFLATE
    assert json.loads(tags["ImageDescription"]) == METADATA
    assert "DateTime" not in tags  # the same picture makes the same file


def test_the_profile_is_srgb_by_what_it_does(tmp_path):
    """Through it to Lab and the sRGB of Pillow's own come the same colours."""
    with tifffile.TiffFile(write_picture(tmp_path / "a.tif", MadePicture())) as whole:
        profile = whole.pages[0].tags["InterColorProfile"].value
    grey = np.arange(256, dtype=np.uint8)
    ramp = Image.fromarray(np.stack([grey, grey[::-1], grey // 2], axis=-1)[None])
    ours = ImageCms.ImageCmsProfile(io.BytesIO(profile))
    through = ImageCms.profileToProfile(ramp, ours, ImageCms.createProfile("sRGB"))
    difference = np.asarray(through).astype(int) - np.asarray(ramp)
    assert np.abs(difference).max() <= 1


def test_another_display_is_said_by_its_profile(tmp_path):
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("LAB")).tobytes()
    file = write_picture(tmp_path / "a.tif", MadePicture(icc=profile))
    with tifffile.TiffFile(file) as whole:
        assert whole.pages[0].tags["InterColorProfile"].value == profile


def test_beyond_4_gib_it_is_a_bigtiff(tmp_path, monkeypatch):
    """The limit is lowered: such pictures are too large for a test."""
    monkeypatch.setattr("skinviz.rendering.formats.tiff._CLASSIC", 100)
    picture = MadePicture()
    file = write_picture(tmp_path / "a.tif", picture)
    with tifffile.TiffFile(file) as whole:
        assert whole.is_bigtiff
        np.testing.assert_array_equal(whole.asarray(), picture.rgb16)


def test_no_imagecodecs_are_needed(tmp_path):
    """It is no dependency; tifffile has what is written here without it."""
    code = (
        "import sys; sys.modules['imagecodecs'] = None\n"
        "sys.path.insert(0, sys.argv[2])\n"
        "from pictures import MadePicture\n"
        "from skinviz.rendering.files import write_picture\n"
        "write_picture(sys.argv[1], MadePicture((300, 70)))\n"
    )
    file = tmp_path / "a.tif"
    paths = (str(file), str(next(p for p in sys.path if p.endswith("tests"))))
    subprocess.run([sys.executable, "-W", "error", "-c", code, *paths], check=True)
    picture = MadePicture((300, 70))
    np.testing.assert_array_equal(tifffile.imread(file), picture.rgb16)
