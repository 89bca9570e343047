"""Whatever bytes a file has: spectra come back, or one SkinvizError.

Warnings are errors in these tests, so that none is raised either.
"""

import os
import shutil

import numpy as np
import pytest
import xarray
from spectra_tables import skin_like, spectra_cube, spectra_list

from skinviz import DataError, SkinvizError, read_spectra, write_spectra
from skinviz.spectra.formats import FORMATS

MUTANTS, SLOW_MUTANTS = 200, 100  # netCDF takes 20 ms a file
NM = [400.0, 500.5, 600.0, 700.0]
NOTES = {"specular": "included", "geometry": "d/8", "comment": "a, b", "date": "2024"}
LIST = spectra_list(skin_like(2, 4), ["left hand", 'the "best"'], NM, **NOTES)
CUBE = spectra_cube(skin_like(3, 2, 4, dtype=np.float32), NM, **NOTES)
WHOLE = {
    **dict.fromkeys((".csv", ".cgats", ".nc"), LIST),
    ".spdx": LIST.isel(record=[0]),
    ".hdr": CUBE,
}
# What parsers look for, to be put where it does not belong.
WORDS = (
    *(b"nan", b"inf", b"-", b"1e999", b"1_0", b'"', b"#", b"\n", b"\r", b",", b"\t"),
    *(b"{", b"}", b"=", b"<", b">", b"&x;", b"<!DOCTYPE a>", b"\0", b"\xff", b"\xc3"),
    *(b"END_DATA\n", b"BEGIN_DATA\n", b"NUMBER_OF_SETS 9\n", b"data type = 6\n"),
    *(b"lines = 0\n", b"bands = 99999999999\n", b"# scale: percent\n", b"9" * 400),
)


def flip(part, rng):
    """Return bytes with one bit turned."""
    if not part:
        return part
    turned = bytearray(part)
    turned[rng.integers(len(part))] ^= 1 << int(rng.integers(8))
    return bytes(turned)


def mutant(content, rng):
    """Return content with one to four faults of a disk, a network or a hand."""
    for _ in range(rng.integers(1, 5)):
        at = int(rng.integers(len(content) + 1))
        to = at + int(rng.integers(1, 40))
        before, part, after = content[:at], content[at:to], content[to:]
        faults = (
            before,
            before + after,
            before + part + part + after,
            before + rng.bytes(len(part)) + after,
            before + WORDS[rng.integers(len(WORDS))] + part + after,
            before + flip(part, rng) + after,
        )
        content = faults[rng.integers(len(faults))]
    return content


def outcome(path):
    """Return what reading gives: "read", or "refused" in one line."""
    told = None
    try:
        found = read_spectra(path)
    except SkinvizError as error:
        told = str(error)
    if told is not None:
        assert "\n" not in told
        return "refused"
    assert isinstance(found, xarray.Dataset)
    assert found.reflectance.dims[-1] == "wavelength"
    assert not np.isinf(found.reflectance.sel(wavelength=slice(400, 700))).any()
    return "read"


@pytest.mark.parametrize("suffix", WHOLE)
def test_a_broken_file_is_read_or_refused(tmp_path, suffix):
    whole = write_spectra(tmp_path / f"whole{suffix}", WHOLE[suffix]).read_bytes()
    path = tmp_path / f"broken{suffix}"
    if suffix == ".hdr":
        shutil.copy(tmp_path / "whole.bip", tmp_path / "broken.bip")
    rng = np.random.default_rng(sum(suffix.encode()))
    outcomes = []
    for _ in range(SLOW_MUTANTS if suffix == ".nc" else MUTANTS):
        path.write_bytes(mutant(whole, rng))
        outcomes.append(outcome(path))
    # Were all of a kind, the faults would be too mild or too coarse to test with.
    assert {"read", "refused"} == set(outcomes)


def test_a_broken_cube_is_read_or_refused(tmp_path):
    """Of raw bytes only their number and infinities can be wrong."""
    path = write_spectra(tmp_path / "whole.hdr", CUBE)
    raw = tmp_path / "whole.bip"
    rng = np.random.default_rng(1)
    for _ in range(100):
        raw.write_bytes(rng.bytes(raw.stat().st_size))
        outcome(path)
    raw.write_bytes(raw.read_bytes()[:-1])
    assert outcome(path) == "refused"


@pytest.mark.parametrize("suffix", FORMATS)
def test_no_bytes_at_all_make_another_error(tmp_path, suffix):
    path = tmp_path / f"noise{suffix}"
    rng = np.random.default_rng(2)
    for n in (1, 2, 3, 8, 100, 1000):
        for content in (rng.bytes(n), bytes(n), b" " * n, b"{" * n, b'"' * n, b"<" * n):
            path.write_bytes(content)
            assert outcome(path) == "refused"


@pytest.mark.parametrize("suffix", [".csv", ".txt", ".spdx", ".hdr"])
def test_a_huge_file_is_refused_before_it_is_read(tmp_path, suffix):
    path = tmp_path / f"huge{suffix}"
    path.touch()
    os.truncate(path, 2**31)  # a hole, which takes no room
    with pytest.raises(DataError, match=r"2048 MiB are too many .*|less than 4 MiB"):
        read_spectra(path)


@pytest.mark.parametrize("suffix", [".csv", ".txt", ".spdx", ".nc", ".hdr"])
def test_a_file_that_fails_while_it_is_read_is_refused(tmp_path, suffix, monkeypatch):
    path = tmp_path / f"hand{suffix}"
    path.write_text("x")

    def broken(*_, **__):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr("pathlib.Path.read_bytes", broken)
    monkeypatch.setattr("h5py.File", broken)
    with pytest.raises(DataError, match=rf"hand\{suffix}: .*Input/output error"):
        read_spectra(path)
