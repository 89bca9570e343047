"""ENVI cubes of radiance: the spectral package and the raw bytes are the oracles."""

import json
import tracemalloc
from dataclasses import dataclass
from urllib.parse import unquote

import numpy as np
import pytest
import spectral.io.envi
from pictures import METADATA, NM, MadePicture

from skinviz import ArgumentError, DataError, read_spectra
from skinviz.rendering.files import read_picture_metadata, write_picture
from skinviz.rendering.formats.picture import radiance_rows
from skinviz.spectra.formats.envi_header import read_header


@pytest.mark.parametrize("size", [(7, 5), (1, 1), (1, 300), (300, 1)])
@pytest.mark.parametrize("at_once", [1, 2, 1000])
def test_spectral_reads_every_value_bit_by_bit(tmp_path, size, at_once):
    picture = MadePicture(size, at_once=at_once)
    image = spectral.io.envi.open(str(write_picture(tmp_path / "a.hdr", picture)))
    found = np.array(image.open_memmap(interleave="bip"))
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, picture.radiance)


def test_the_raw_file_is_the_radiance_and_nothing_else(tmp_path):
    picture = MadePicture()
    write_picture(tmp_path / "a.hdr", picture)
    content = (tmp_path / "a.bip").read_bytes()
    assert content == picture.radiance.astype("<f4").tobytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.bip", "a.hdr"]


def test_the_header_says_the_wavelengths_and_what_it_is(tmp_path):
    wavelengths = np.array([380 + 1 / 3, 459.0, 551.0, 641.0, 780.0])
    picture = MadePicture(wavelengths=wavelengths)
    file = write_picture(tmp_path / "a.hdr", picture)
    image = spectral.io.envi.open(str(file))
    assert image.bands.centers == wavelengths.tolist()
    assert image.bands.band_unit == "Nanometers"
    assert image.metadata["description"] == (
        "Linke Hand, 60°/60°; spectral radiance [1 / white under light 1 (per band)]"
    )
    assert image.metadata["default bands"] == ["4", "3", "2"]


def test_other_readers_find_the_metadata_as_percent_encoded_json(tmp_path):
    """In one piece: a comma would make spectral a list of it."""
    file = write_picture(tmp_path / "a.hdr", MadePicture())
    (text,) = spectral.io.envi.open(str(file)).metadata["skinviz picture"]
    assert json.loads(unquote("".join(text.split()))) == METADATA
    assert json.loads(unquote("".join(read_header(file)["skinviz picture"].split())))
    assert max(map(len, file.read_text().splitlines())) < 120


@dataclass(frozen=True)
class LargePicture:
    """A picture whose rows are made when they are asked for."""

    size = (512, 1024)
    wavelengths = np.linspace(400, 700, 61)
    metadata = METADATA
    rows_at_once = 8

    def rows(self, advance=None):  # noqa: ARG002
        width, height = self.size
        for top in range(0, height, self.rows_at_once):
            shape = (self.rows_at_once, width, self.wavelengths.size)
            yield np.full(shape, top, dtype=np.float32)


def test_the_memory_is_that_of_some_rows(tmp_path):
    """A cube of 16 GB needs no more than one of 128 MB."""
    picture = LargePicture()
    block = picture.rows_at_once * 512 * 61 * 4
    tracemalloc.start()
    write_picture(tmp_path / "a.hdr", picture)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert (tmp_path / "a.bip").stat().st_size == 512 * 1024 * 61 * 4
    assert peak < 2.5 * block
    found = np.memmap(tmp_path / "a.bip", "<f4", "r", shape=(1024, 512 * 61))
    assert (found[::8] == np.arange(0, 1024, 8)[:, None]).all()


def test_radiance_is_not_read_as_reflectance(tmp_path):
    file = write_picture(tmp_path / "a.hdr", MadePicture())
    with pytest.raises(DataError, match=r"radiance of a picture .* is no reflectance"):
        read_spectra(file)
    # Without that mark the bytes and bands are those that a cube has.
    header = file.read_text()
    file.write_text(header[: header.index("skinviz picture")])
    found = read_spectra(file)
    np.testing.assert_array_equal(found.reflectance, MadePicture().radiance)
    np.testing.assert_array_equal(found.wavelength, NM)


@pytest.mark.parametrize("raw", ["a.img", "a.bip", "a"])
def test_a_raw_file_of_others_is_neither_lost_nor_mistaken(tmp_path, raw):
    (tmp_path / raw).write_bytes(b"mine")
    with pytest.raises(ArgumentError, match=f"{raw} lies beside it"):
        write_picture(tmp_path / "a.hdr", MadePicture())
    assert [p.name for p in tmp_path.iterdir()] == [raw]
    assert (tmp_path / raw).read_bytes() == b"mine"


def test_a_cube_is_written_over_its_former_self(tmp_path):
    write_picture(tmp_path / "a.hdr", MadePicture((9, 9)))
    picture = MadePicture((3, 2), metadata={"title": "new"})
    file = write_picture(tmp_path / "a.hdr", picture)
    assert (tmp_path / "a.bip").read_bytes() == picture.radiance.tobytes()
    assert read_picture_metadata(file) == {"title": "new"}
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.bip", "a.hdr"]


class Rows(MadePicture):
    """A picture whose rows are not what its size says."""

    def __init__(self, blocks):
        super().__init__()
        object.__setattr__(self, "blocks", blocks)

    def rows(self, advance=None):  # noqa: ARG002
        yield from self.blocks


GOOD = np.ones((2, 7, 4), dtype=np.float32)
LAST = np.ones((1, 7, 4), dtype=np.float32)


def with_one(value):
    block = GOOD.copy()
    block[1, 6, 3] = value
    return block


@pytest.mark.parametrize(
    ("blocks", "told"),
    [
        ([GOOD, GOOD], "4 rows of radiance came for 5"),
        ([GOOD, GOOD, GOOD], "6 rows of radiance came for 5"),
        ([], "0 rows of radiance came for 5"),
        ([GOOD[:, :6], GOOD], r"of shape \(2, 6, 4\); expected float32 \(rows, 7, 4\)"),
        ([GOOD[..., 0]], r"of shape \(2, 7\); expected"),
        ([GOOD.astype(float)], "are float64"),
        ([GOOD, with_one(np.nan), LAST], "the radiance is not finite in rows 2 to 3"),
        ([with_one(np.inf), GOOD, LAST], "not finite in rows 0 to 1"),
        ([with_one(-np.inf), GOOD, LAST], "not finite in rows 0 to 1"),
    ],
)
@pytest.mark.parametrize("suffix", [".hdr", ".exr"])
def test_rows_that_are_not_the_pictures_are_refused(tmp_path, blocks, told, suffix):
    with pytest.raises(ArgumentError, match=told):
        write_picture(tmp_path / f"a{suffix}", Rows(blocks))
    assert not list(tmp_path.iterdir())


def test_rows_may_come_in_any_number(tmp_path):
    blocks = [GOOD[:0], LAST, GOOD, GOOD[:0], GOOD]
    found = list(radiance_rows(Rows(blocks), tmp_path / "a.hdr", None))
    assert sum(map(len, found)) == 5
