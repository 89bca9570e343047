"""ICC profiles: the numbers of Little CMS, and one refusal for all that is broken."""

import io
import struct

import icc_profiles as make
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from PIL import Image, ImageCms

from skinviz import DataError, SkinvizError
from skinviz.spectra.colorimetry import SRGB_FROM_XYZ, xyz_to_lab
from skinviz.spectra.display import SRGB, read_icc

FIXED = 1 / 65536
"""The unit in which a profile writes its numbers."""

TABLE = make.table_tag(np.round(65535 * np.linspace(0, 1, 1024) ** 1.8))
COARSE = make.table_tag([0, 900, 9000, 30000, 65535])
SRGB_LAW = make.parametric_tag(3, 2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)
CURVES = {
    "gamma": [make.gamma_tag(2.2)] * 3,
    "three gammas": [make.gamma_tag(g) for g in (1.8, 2.2, 2.4)],
    "none": [make.table_tag([])] * 3,
    "table": [TABLE] * 3,
    "coarse table": [COARSE] * 3,
    "type 0": [make.parametric_tag(0, 2.4)] * 3,
    "type 1": [make.parametric_tag(1, 2.0, 1.1, -0.1)] * 3,
    "type 2": [make.parametric_tag(2, 2.0, 0.95, -0.02, 0.02)] * 3,
    "type 3": [SRGB_LAW] * 3,
    "type 4": [make.parametric_tag(4, 2.4, 0.93, 0.055, 0.07, 0.04, 0.01, 0.010475)]
    * 3,
    "of several kinds": [TABLE, SRGB_LAW, make.gamma_tag(2.2)],
}


@pytest.fixture
def read(tmp_path):
    """Return a function that reads a profile's bytes from a file."""

    def run(content, name="made.icc"):
        path = tmp_path / name
        path.write_bytes(content)
        return read_icc(path)

    return run


def little_cms(content):
    return ImageCms.ImageCmsProfile(io.BytesIO(content))


def srgb_bytes():
    return ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()


def converted(levels, source, target, mode):
    """Convert 8-bit colours (n, 3) by Little CMS, white to white."""
    change = ImageCms.buildTransform(
        source,
        target,
        "RGB",
        mode,
        renderingIntent=ImageCms.Intent.RELATIVE_COLORIMETRIC,
        flags=ImageCms.Flags.NOOPTIMIZE,  # no tables between: to rounding
    )
    picture = Image.fromarray(levels[np.newaxis])
    shown = ImageCms.applyTransform(picture, change)
    return np.frombuffer(shown.tobytes(), np.uint8).reshape(-1, 3)


def some_levels():
    """Return colours over the cube, its corners, edges and greys."""
    rng = np.random.default_rng(0)
    corners = np.array(np.meshgrid(*[[0, 255]] * 3)).reshape(3, -1).T
    greys = np.repeat(np.arange(256)[:, None], 3, axis=1)
    return np.concatenate([corners, greys, rng.integers(0, 256, (2000, 3))]).astype(
        np.uint8
    )


# --- against Little CMS -----------------------------------------------------------


def test_pillows_srgb_is_srgb(read):
    display = read(srgb_bytes())
    assert_allclose(display.matrix, SRGB_FROM_XYZ, rtol=0, atol=5e-4)
    levels = np.arange(256)[:, None].repeat(3, axis=1) / 255
    assert_allclose(display.decode(levels), SRGB.decode(levels), rtol=0, atol=4 * FIXED)
    assert_allclose(display.encode(levels), SRGB.encode(levels), rtol=0, atol=2e-4)


@pytest.mark.parametrize("white", [make.D65_XY, make.D93_XY], ids=["D65", "D93"])
@pytest.mark.parametrize("version", [2, 4])
def test_the_numbers_are_those_that_little_cms_reads(read, version, white):
    content = make.profile(
        make.display_tags(white=white, version=version), version=version
    )
    display, told = read(content), little_cms(content).profile
    xyz = [told.red_colorant[0], told.green_colorant[0], told.blue_colorant[0]]
    adapted = np.array(xyz).T
    if version == 4:
        matrix = np.array(told.chromatic_adaptation[0])
        shown = np.linalg.solve(matrix, adapted)
    else:
        # Little CMS undoes Bradford by the white that version 2 keeps.
        shown = np.linalg.solve(make.to_d50(white), adapted)
    assert_allclose(np.linalg.inv(display.matrix), shown, rtol=0, atol=4 * FIXED)


@pytest.mark.parametrize("version", [2, 4])
@pytest.mark.parametrize("white", [make.D65_XY, make.D93_XY], ids=["D65", "D93"])
def test_what_is_shown_is_the_true_xyz(read, version, white):
    # The profile has it adapted to D50; the display that was described is another.
    tags = make.display_tags(make.WIDE_XY, white, version=version)
    display = read(make.profile(tags, version=version))
    expected = make.primaries(make.WIDE_XY, white)
    assert_allclose(np.linalg.inv(display.matrix), expected, rtol=0, atol=5e-5)
    assert_allclose(display.white, make.xyz_of(white), rtol=0, atol=1e-4)


@pytest.mark.parametrize("curves", CURVES.values(), ids=CURVES)
@pytest.mark.parametrize("version", [2, 4])
def test_levels_have_the_lab_of_little_cms(read, curves, version):
    content = make.profile(
        make.display_tags(curves=curves, version=version), version=version
    )
    display, levels = read(content), some_levels()
    xyz = display.decode(levels / 255) @ np.linalg.inv(display.matrix).T
    lab = xyz_to_lab(xyz @ make.to_d50(make.D65_XY).T, make.D50)
    told = converted(
        levels, little_cms(content), ImageCms.createProfile("LAB"), "LAB"
    ).astype(float)
    told[:, 0] *= 100 / 255
    told[:, 1:] = told[:, 1:].astype(np.uint8).astype(np.int8)
    inside = (np.abs(lab[:, 1:]) < 127).all(axis=1)
    assert inside.sum() > 1000
    # Half a step of 8 bits, and what rounding to 1/65536 in the profile adds.
    half = np.array([50 / 255, 0.5, 0.5]) + 0.005
    assert (np.abs(lab - told)[inside] < half).all()


@pytest.mark.parametrize("curves", CURVES.values(), ids=CURVES)
def test_srgb_is_encoded_as_little_cms_encodes_it(read, curves):
    content = make.profile(make.display_tags(make.WIDE_XY, curves=curves))
    display, levels = read(content), some_levels()
    srgb = read(srgb_bytes(), "srgb.icc")
    xyz = srgb.decode(levels / 255) @ np.linalg.inv(srgb.matrix).T
    found, counts = display.encode8(display.linear(xyz))
    told = converted(levels, little_cms(srgb_bytes()), little_cms(content), "RGB")
    apart = np.abs(found.astype(int) - told)
    # Below the flat part of a curve, several levels are as dark.
    as_light = display.decode(found / 255) == display.decode(told / 255)
    assert ((apart <= 1) | as_light).all()
    assert (apart > 0)[~as_light].sum() < 15
    assert counts.total == len(levels)


# --- what else a profile has -----------------------------------------------------


def test_the_profile_is_kept_to_be_put_into_pictures(read):
    content = make.profile(make.display_tags())
    display = read(content)
    assert display.icc == content
    assert display.profile() == content


@pytest.mark.parametrize("version", [2, 4])
def test_a_display_has_the_profiles_name(read, version):
    tags = make.display_tags(version=version)
    assert read(make.profile(tags, version=version)).name == "made"
    del tags["desc"]
    display = read(make.profile(tags, version=version), "screen 3.icm")
    assert display.name == "screen 3"


@pytest.mark.parametrize(
    "data",
    [b"desc\0\0\0\0\xff\xff\xff\xff\x07\0\0", b"mluc" + b"\xff" * 30, b"desc", b"odd "],
)
def test_a_broken_name_does_no_harm(read, data):
    assert read(make.profile(make.display_tags() | {"desc": data})).name == "made"


def test_version_4_without_chad_has_white_d50(read):
    tags = make.display_tags()
    del tags["chad"]
    display = read(make.profile(tags))
    assert_allclose(display.white, make.D50, rtol=0, atol=1e-4)


@pytest.mark.parametrize(("kind", "own"), [(b"mntr", True), (b"spac", False)])
def test_only_displays_of_version_2_keep_their_white(read, kind, own):
    tags = make.display_tags(version=2)
    display = read(make.profile(tags, version=2, kind=kind))
    expected = make.xyz_of(make.D65_XY) if own else make.D50
    assert_allclose(display.white, expected, rtol=0, atol=1e-4)


def test_every_level_survives_the_journey(read):
    levels = some_levels()
    for name, curves in CURVES.items():
        display = read(make.profile(make.display_tags(curves=curves)))
        back, counts = display.encode8(display.decode(levels / 255))
        if name.startswith("type") and name[-1] in "12":
            # Several levels are as dark as black: any of them is right.
            assert_array_equal(
                display.decode(back / 255), display.decode(levels / 255), name
            )
        else:
            assert_array_equal(back, levels, name)
        assert (counts.over_exposed, counts.out_of_gamut) == (0, 0)


# --- refusals ----------------------------------------------------------------------

GOOD = make.display_tags()
LUT = {"A2B0": b"mft2" + bytes(60), "desc": make.text_tag("table")}
DEFECTS = {
    "no profile at all": (b"P6 4 4 255" + bytes(200), "no header with the mark 'acsp'"),
    "a short file": (make.profile(GOOD)[:100], "no header with the mark 'acsp'"),
    "cut off": (make.profile(GOOD)[:-8], "is cut off"),
    "a printer": (make.profile(GOOD, kind=b"prtr"), "class 'prtr'; expected mntr"),
    "CMYK": (make.profile(GOOD, space=b"CMYK"), "colour space 'CMYK'"),
    "Lab behind": (make.profile(GOOD, connection=b"Lab "), "connection space 'Lab '"),
    "look-up tables alone": (
        make.profile(LUT),
        "no rXYZ, gXYZ, bXYZ, rTRC, gTRC, bTRC but look-up tables; .*matrix/TRC",
    ),
    "no blue": (
        make.profile({k: v for k, v in GOOD.items() if k != "bXYZ"}),
        "has no bXYZ; a profile with primaries",
    ),
    "short primary": (
        make.profile(GOOD | {"rXYZ": b"XYZ \0\0\0\0" + bytes(8)}),
        "has in rXYZ 'XYZ ' of 16 bytes",
    ),
    "primary of another kind": (
        make.profile(GOOD | {"rXYZ": make.gamma_tag(2)}),
        "has in rXYZ 'curv'",
    ),
    "dim primaries": (
        make.profile(GOOD | {"gXYZ": make.xyz_tag([0.1, 0.1, 0.1])}),
        "primaries that add to Y",
    ),
    "equal primaries": (
        make.profile(
            GOOD | dict.fromkeys(("rXYZ", "gXYZ", "bXYZ"), make.xyz_tag(make.D50 / 3))
        ),
        "a mixture of the others",
    ),
    "chad that squashes": (
        make.profile(GOOD | {"chad": make.chad_tag(np.ones((3, 3)))}),
        "cannot be undone",
    ),
    "short chad": (make.profile(GOOD | {"chad": b"sf32" + bytes(9)}), "has in chad"),
    "black white": (
        make.profile(
            make.display_tags(version=2) | {"wtpt": make.xyz_tag([0, 0, 0])}, version=2
        ),
        "which is none",
    ),
    "curve of another kind": (
        make.profile(GOOD | {"rTRC": make.xyz_tag(make.D50)}),
        "expected 'curv' or 'para'",
    ),
    "short table": (
        make.profile(GOOD | {"gTRC": TABLE[:-10]}),
        "has in gTRC 2050 bytes for 1024 points",
    ),
    "endless table": (
        make.profile(GOOD | {"gTRC": b"curv\0\0\0\0\xff\xff\xff\xff"}),
        "for 4294967295 points",
    ),
    "falling table": (
        make.profile(GOOD | {"gTRC": make.table_tag([65535, 0])}),
        "has in gTRC no curve of a display: .*must not fall",
    ),
    "dark table": (make.profile(GOOD | {"gTRC": make.table_tag([0] * 9)}), "0 to 1"),
    "gamma 0": (make.profile(GOOD | {"bTRC": make.gamma_tag(0)}), "gamma must be in"),
    "unknown function": (
        make.profile(GOOD | {"bTRC": make.parametric_tag(7, *[1.0] * 9)}),
        "function of type 7; 0 to 4",
    ),
    "short function": (
        make.profile(GOOD | {"bTRC": make.parametric_tag(3, 2.4, 1.0)}),
        "bytes for 5 numbers",
    ),
    "function over 0": (
        make.profile(GOOD | {"bTRC": make.parametric_tag(1, 2.0, 0.0, 0.1)}),
        "divides by 0",
    ),
    "falling function": (
        make.profile(GOOD | {"bTRC": make.parametric_tag(3, 2.0, 1.0, 0.0, 2.0, 0.5)}),
        "must not fall",
    ),
    "huge function": (
        make.profile(GOOD | {"bTRC": make.parametric_tag(1, 9.0, 32000.0, 0.0)}),
        "expected about 0 to 1",
    ),
}


@pytest.mark.parametrize(("content", "told"), DEFECTS.values(), ids=DEFECTS)
def test_what_is_no_display_is_refused_in_one_line(read, content, told):
    with pytest.raises(DataError, match=told) as caught:
        read(content)
    assert "made.icc" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("count", [0, 999, 2**32 - 1])
def test_a_false_count_of_tags_is_refused(read, count):
    content = bytearray(make.profile(GOOD))
    content[128:132] = struct.pack(">I", count)
    with pytest.raises(DataError):
        read(bytes(content))


@pytest.mark.parametrize("offset", [2**31, 2**32 - 4])
def test_a_tag_beyond_the_end_is_refused(read, offset):
    content = bytearray(make.profile(GOOD))
    content[136:140] = struct.pack(">I", offset)
    with pytest.raises(DataError, match="beyond its end"):
        read(bytes(content))


def test_files_that_are_none_are_refused(tmp_path):
    with pytest.raises(DataError, match="no such file"):
        read_icc(tmp_path / "none.icc")
    with pytest.raises(DataError, match="is a folder"):
        read_icc(tmp_path)
    (tmp_path / "empty.icc").touch()
    with pytest.raises(DataError, match="is empty"):
        read_icc(tmp_path / "empty.icc")


def test_a_huge_file_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "huge.icc"
    with path.open("wb") as file:
        file.truncate(2**26 + 1)
    with pytest.raises(DataError, match="at most 64 MiB"):
        read_icc(path)


def test_a_file_that_fails_while_it_is_read_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "a.icc"
    path.write_bytes(make.profile(GOOD))

    def fail(_):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(type(path), "read_bytes", fail)
    with pytest.raises(DataError, match="cannot be read: Input/output error"):
        read_icc(path)


def test_a_broken_profile_is_read_or_refused(read):
    """Whatever bytes it has: a display without NaN, or one SkinvizError."""
    rng = np.random.default_rng(0)
    whole = make.profile(
        make.display_tags(curves=[COARSE, SRGB_LAW, make.gamma_tag(2.2)])
    )
    colours = rng.uniform(-0.1, 1.1, (20, 3))
    outcomes = []
    for _ in range(400):
        broken = bytearray(whole)
        for _ in range(rng.integers(1, 4)):
            at = int(rng.integers(len(broken)))
            length = int(rng.integers(1, 5))
            broken[at : at + length] = rng.bytes(int(rng.choice([length, 0, length])))
        try:
            display = read(bytes(broken))
            display.encode8(display.linear(colours))
            assert np.isfinite(display.encode(colours)).all()
            outcomes.append(True)
        except SkinvizError:
            outcomes.append(False)
    assert 20 < sum(outcomes) < 380
