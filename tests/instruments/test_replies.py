"""Replies as pure functions: manuals' examples, codes, and any accident on the way."""

import numpy as np
import pytest
from benches import (
    GRID,
    PARSERS,
    cr250_reply,
    met,
    mutated,
    pr650_reply,
    pr655_reply,
    spectrum,
)
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from skinviz.instruments import cr250_replies, pr650_replies, pr655_replies
from skinviz.instruments.errors import (
    CommandRejected,
    DeviceFault,
    InstrumentError,
    MalformedReply,
    MeasurementRefused,
    NotHomed,
    OutOfTravel,
    OverRange,
    StageFault,
    TooDark,
    Unsteady,
)
from skinviz.instruments.meters import Grid
from skinviz.instruments.zaber_replies import (
    checksum,
    command,
    reply_of,
    require_sound,
)

FOUR_DIGITS = 5.1e-4


@pytest.mark.parametrize("digits", [2, 3])
def test_a_pr655_spectrum_is_read_whatever_its_exponents(digits):
    values = spectrum()
    found = pr655_replies.spectrum_of(pr655_reply(values, digits=digits), GRID)
    assert_allclose(found.radiance, values, rtol=FOUR_DIGITS, atol=0)


def test_the_manuals_grids_are_read():
    line = b"00000,201,0.00,380,780,2,256,7,247"
    assert pr655_replies.grid_of(line) == Grid(380.0, 2.0, 201)
    line = b"0101,008.0,0380.,0780.,4."
    assert pr650_replies.grid_of(line) == GRID
    assert cr250_replies.grid_of(b"OK:0:RM Spectrum:380.0,780.0,2.0,201").count == 201


@pytest.mark.parametrize("line", [b"0,201,0,380,780,4,1,1,1", b"0,1e300,0,380,780,2"])
def test_a_grid_that_contradicts_itself_is_refused(line):
    with pytest.raises(MalformedReply):
        pr655_replies.grid_of(line)


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        (b"-8", TooDark),
        (b"-0008", TooDark),
        (b"-2", OverRange),
        (b"-1", Unsteady),
        (b"-12", Unsteady),
        (b"-10", Unsteady),
        (b"-4", MeasurementRefused),
        (b"-1000", CommandRejected),
        (b"-1035", CommandRejected),
        (b"-2000", CommandRejected),
        (b"-77", MalformedReply),
        (b"hello", MalformedReply),
        (b"", MalformedReply),
    ],
)
def test_pr655_codes(line, kind):
    with pytest.raises(kind) as caught:
        pr655_replies.require_well(line)
    assert caught.value.raw == line


def test_exposures_are_read_where_they_are_told():
    assert pr655_replies.exposure_of(b"00000,0,120.00") == 0.12
    assert pr655_replies.exposure_of(b"00000,fast, 120 ms") == 0.12
    assert pr655_replies.exposure_of(b"00000") is None
    assert pr655_replies.exposure_of(b"00000,adaptive") is None


def test_a_pr650_reply_has_the_manuals_length_and_is_read():
    values = spectrum()
    raw = pr650_reply(values)
    assert len(raw) == 6 + 11 + 101 * 17
    found = pr650_replies.spectrum_of(raw, GRID)
    assert_allclose(found.radiance, values, rtol=FOUR_DIGITS, atol=0)
    assert found.warnings == ()


def test_low_light_is_a_warning_and_too_little_a_refusal():
    found = pr650_replies.spectrum_of(pr650_reply(spectrum(), "18"), GRID)
    assert found.warnings == ("low light",)
    with pytest.raises(TooDark):
        pr650_replies.spectrum_of(pr650_reply(spectrum(), "10"), GRID)


@pytest.mark.parametrize(
    ("code", "kind"),
    [
        (7, Unsteady),
        (10, TooDark),
        (12, DeviceFault),
        (17, DeviceFault),
        (19, OverRange),
        (29, MeasurementRefused),
        (99, MalformedReply),
    ],
)
def test_pr650_qualities(code, kind):
    with pytest.raises(kind):
        pr650_replies.require_quality(b"%02d,0" % code)


def test_another_rule_of_a_pr650s_integral_is_believed_when_it_comes_twice():
    values = spectrum()
    trapezoid = (values.sum() - (values[0] + values[-1]) / 2) * 4
    assert (
        pr650_replies.spectrum_of(
            pr650_reply(values, integral=trapezoid), GRID
        ).warnings
        == ()
    )
    other = pr650_reply(values, integral=values.sum())
    with pytest.raises(MalformedReply, match="add up"):
        pr650_replies.spectrum_of(other, GRID)
    found = pr650_replies.spectrum_of(other, GRID, doubted=True)
    assert "another rule" in found.warnings[0]


def test_a_cr250_spectrum_is_read():
    values = spectrum()
    grid, found = cr250_replies.spectrum_of(cr250_reply(values))
    assert grid == GRID
    assert_allclose(found.radiance, values, rtol=1e-6, atol=0)


@pytest.mark.parametrize(
    ("code", "kind"),
    [
        (-302, Unsteady),
        (-303, Unsteady),
        (-305, TooDark),
        (-306, OverRange),
        (-331, DeviceFault),
        (-500, CommandRejected),
        (-42, MeasurementRefused),
        (3, MalformedReply),
    ],
)
def test_cr250_errors(code, kind):
    with pytest.raises(kind):
        cr250_replies.answer(b"ER:%d:M:some words: and more" % code, b"M")


def test_a_cr250_warning_comes_with_data():
    assert cr250_replies.answer(b"OK:101:M:", b"M")[1] == (
        "the source does not flicker",
    )
    with pytest.raises(MalformedReply, match="came for"):
        cr250_replies.answer(b"OK:0:RC ID:1", b"M")


def test_checksums_of_the_protocols_examples():
    assert checksum(b"01 1 get pos") == b"7C"
    assert checksum(b"01 1 OK IDLE -- 96000") == b"BD"
    assert checksum(b"01 1 RJ IDLE WR BADDATA") == b"8A"
    assert command("get pos", message=7).startswith(b"/01 1 07 get pos:")


def test_zaber_replies_are_read_with_and_without_number_and_checksum():
    assert reply_of(b"@01 1 OK IDLE -- 96000:BD").data == "96000"
    reply = reply_of(b"@01 1 17 OK BUSY -- 0")
    assert (reply.accepted, reply.busy, reply.message) == (True, True, 17)
    with pytest.raises(MalformedReply, match="checksum"):
        reply_of(b"@01 1 OK IDLE -- 96001:BD")


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        (b"@01 1 RJ IDLE WR BADDATA", NotHomed),
        (b"@01 1 RJ IDLE -- BADDATA", OutOfTravel),
        (b"@01 1 RJ IDLE -- BADCOMMAND", CommandRejected),
        (b"@01 1 OK IDLE FS 0", StageFault),
    ],
)
def test_what_a_stage_complains_of(line, kind):
    with pytest.raises(kind):
        require_sound(reply_of(line))


@pytest.mark.parametrize("name", PARSERS)
def test_well_formed_replies_are_read(name):
    raw, parse = PARSERS[name]
    assert met(parse, raw) == "read"


@pytest.mark.parametrize("name", PARSERS)
@given(seed=st.integers(0, 2**32))
def test_no_accident_is_worse_than_an_error_of_ours(name, seed):
    raw, parse = PARSERS[name]
    met(parse, mutated(raw, np.random.default_rng(seed)))


@given(st.binary(max_size=300))
def test_nor_is_noise(noise):
    for _, parse in PARSERS.values():
        met(parse, noise)


@given(data=st.data())
def test_no_part_of_a_spectrum_is_taken_for_it(data):
    for make, parse in (
        (pr655_reply, pr655_replies.spectrum_of),
        (pr650_reply, pr650_replies.spectrum_of),
    ):
        whole = make(spectrum())
        end = data.draw(st.integers(0, len(whole) - 3))
        with pytest.raises(InstrumentError):
            parse(whole[:end], GRID)
        at = data.draw(st.integers(1, 100))
        lines = whole.splitlines(keepends=True)
        with pytest.raises(InstrumentError):
            parse(b"".join(lines[:at] + lines[at + 1 :]), GRID)


@given(seed=st.integers(0, 2**32))
def test_a_digit_that_the_integral_can_tell_is_never_accepted(seed):
    rng = np.random.default_rng(seed)
    values = spectrum(seed % 7)
    whole = bytearray(pr655_reply(values))
    first = whole.index(b"\n") + 1
    at = int(rng.integers(first, len(whole)))
    whole[at] ^= 1 << int(rng.integers(0, 7))
    try:
        found = pr655_replies.spectrum_of(bytes(whole), GRID)
    except InstrumentError:
        return
    total = values.sum()
    assert abs(found.radiance.sum() - total) <= 1.2e-3 * total
    assert_array_equal(found.radiance.shape, values.shape)
