"""PNG files: chunks taken apart by hand, and Pillow, are the oracles."""

import struct
import zlib

import numpy as np
import pytest
from pictures import METADATA, MadePicture
from PIL import Image, ImageCms

from skinviz.rendering.files import read_picture_metadata, write_picture
from skinviz.rendering.formats.tiff import srgb_profile


def chunks(content):
    """Names and contents of a PNG file's chunks, their checksums checked."""
    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    at, found = 8, []
    while at < len(content):
        (length,) = struct.unpack(">I", content[at : at + 4])
        name, data = content[at + 4 : at + 8], content[at + 8 : at + 8 + length]
        (check,) = struct.unpack(">I", content[at + 8 + length : at + 12 + length])
        assert zlib.crc32(name + data) == check
        found.append((name, data))
        at += 12 + length
    return found


@pytest.mark.parametrize("size", [(7, 5), (1, 1), (1, 300), (300, 1)])
def test_pillow_reads_the_colours_bit_by_bit(tmp_path, size):
    picture = MadePicture(size)
    with Image.open(write_picture(tmp_path / "a.png", picture)) as image:
        assert image.mode == "RGB"
        assert image.size == size
        np.testing.assert_array_equal(np.asarray(image), picture.rgb)


def test_srgb_is_said_by_its_chunk_and_for_older_readers_by_the_gamma(tmp_path):
    found = chunks(write_picture(tmp_path / "a.png", MadePicture()).read_bytes())
    names = [name for name, _ in found]
    assert dict(found)[b"sRGB"] == b"\x00"
    assert struct.unpack(">I", dict(found)[b"gAMA"]) == (45455,)
    assert names.index(b"sRGB") < names.index(b"IDAT")
    assert b"iCCP" not in names
    assert b"tIME" not in names  # the same picture makes the same file


def test_another_display_is_said_by_its_profile(tmp_path):
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("LAB")).tobytes()
    file = write_picture(tmp_path / "a.png", MadePicture(icc=profile))
    assert not {b"sRGB", b"gAMA"} & {name for name, _ in chunks(file.read_bytes())}
    with Image.open(file) as image:
        assert image.info["icc_profile"] == profile


def test_texts_are_international_and_before_the_pixels(tmp_path):
    file = write_picture(tmp_path / "a.png", MadePicture())
    names = [name for name, _ in chunks(file.read_bytes())]
    assert names.count(b"iTXt") == 3
    assert names.index(b"IDAT") > max(i for i, n in enumerate(names) if n == b"iTXt")
    with Image.open(file) as image:
        assert image.info["Title"] == METADATA["title"]
        assert image.info["Software"].startswith("skinviz ")


def test_large_pictures_are_asked_without_a_warning(tmp_path, monkeypatch):
    """Pillow warns of pictures beyond a limit, as 16384 × 16384 is."""
    file = write_picture(tmp_path / "a.png", MadePicture())
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 4)
    assert read_picture_metadata(file) == METADATA


def test_the_profile_of_srgb_is_that_and_the_same_at_any_time():
    profile = srgb_profile()
    assert profile[24:36] == struct.pack(">6H", 2000, 1, 1, 0, 0, 0)
    assert profile == srgb_profile()
    assert profile[36:40] == b"acsp"
    assert struct.unpack(">I", profile[:4]) == (len(profile),)
