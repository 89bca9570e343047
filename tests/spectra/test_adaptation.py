"""Adaptation of white: colour-science's matrix, and whites that are none."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from tolerances import ORACLE, ROUNDING

from skinviz import ArgumentError
from skinviz.spectra.adaptation import (
    ADAPTATIONS,
    BRADFORD,
    CAT16,
    adaptation,
    cat16_matrix,
    von_kries,
)
from skinviz.spectra.colorimetry import (
    colour_matching_functions,
    spectrum_to_xyz,
)
from skinviz.spectra.display import SRGB
from skinviz.spectra.illuminants import black_body, illuminants
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS as NM


def white_of(light):
    return spectrum_to_xyz(np.ones(NM.size), NM, light)


WHITES = [white_of(name) for name in illuminants()] + [
    white_of(black_body(kelvin)) for kelvin in (1500, 3200, 1e6)
]


@pytest.mark.parametrize("white", WHITES)
@pytest.mark.parametrize("target", [SRGB.white, [1, 1, 1]], ids=["sRGB", "E"])
def test_cat16_is_colour_sciences(colour, white, target):
    expected = colour.adaptation.matrix_chromatic_adaptation_VonKries(
        white, target, transform="CAT16"
    )
    assert_allclose(cat16_matrix(white, target), expected, rtol=0, atol=ORACLE)
    rng = np.random.default_rng(0)
    xyz = rng.uniform(0, 1, (50, 3))
    told = colour.adaptation.chromatic_adaptation_VonKries(
        xyz, white, target, transform="CAT16"
    )
    assert_allclose(xyz @ cat16_matrix(white, target).T, told, rtol=0, atol=ORACLE)


def test_bradford_is_colour_sciences(colour):
    expected = colour.adaptation.matrix_chromatic_adaptation_VonKries(
        [0.95, 1, 1.09], [0.9642, 1, 0.8249], transform="Bradford"
    )
    found = von_kries(
        np.array([0.95, 1, 1.09]), np.array([0.9642, 1, 0.8249]), BRADFORD
    )
    assert_allclose(found, expected, rtol=0, atol=ORACLE)


@pytest.mark.parametrize("white", WHITES)
def test_white_becomes_the_target(white):
    assert_allclose(cat16_matrix(white, SRGB.white) @ white, SRGB.white, rtol=ORACLE)


def test_nothing_changes_between_equal_whites():
    assert_allclose(cat16_matrix([0.9, 1, 1.1], [0.9, 1, 1.1]), np.eye(3), atol=1e-15)


def test_the_way_back_undoes_the_way_there():
    a, b = WHITES[0], WHITES[4]
    assert_allclose(cat16_matrix(b, a) @ cat16_matrix(a, b), np.eye(3), atol=1e-14)


def test_a_stop_between_does_not_matter():
    a, b, c = WHITES[0], WHITES[4], WHITES[5]
    by_way = cat16_matrix(b, c) @ cat16_matrix(a, b)
    assert_allclose(by_way, cat16_matrix(a, c), rtol=0, atol=1e-14)


@pytest.mark.parametrize("scale", [1e-300, 1e-30, 1e30, 1e300])
def test_each_white_has_its_own_scale(scale):
    plain = cat16_matrix(WHITES[0], SRGB.white)
    if scale < 1e200:
        scaled = cat16_matrix(WHITES[0], SRGB.white * scale)
        assert_allclose(scaled, plain * scale, rtol=1e-10, atol=1e-14 * scale)
    scaled = cat16_matrix(WHITES[0] * scale, SRGB.white * scale)
    assert_allclose(scaled, plain, rtol=ROUNDING, atol=1e-14)


def test_adaptations_have_names():
    assert ADAPTATIONS == ("none", "cat16")
    assert_array_equal(adaptation("none", WHITES[0], SRGB.white), np.eye(3))
    assert_array_equal(
        adaptation("cat16", WHITES[0], SRGB.white), cat16_matrix(WHITES[0], SRGB.white)
    )
    with pytest.raises(
        ArgumentError, match=r"unknown adaptation 'cat02'; choose .*cat"
    ):
        adaptation("cat02", WHITES[0], SRGB.white)


def test_none_does_not_look_at_whites():
    assert_array_equal(adaptation("none", [0, 0, 0], [0, 0, 0]), np.eye(3))


@pytest.mark.parametrize(
    "white",
    [
        [0.0, 0.0, 0.0],
        [0.95, 1.0, 0.0],
        [0.0, 1.0, 1.0],
        [0.95, 1.0, 1e-3],
        [0.95, 1.0, -0.1],
        [-0.1, 1.0, 1.0],
        [0.95, 0.0, 1.09],
        [0.95, -1.0, 1.09],
        [-0.95, -1.0, -1.09],
        [1e-30, 1e-30, 1e-34],
    ],
)
def test_whites_that_are_none_are_refused(white):
    with pytest.raises(ArgumentError, match=r"white .* so far from white .* 'none'"):
        cat16_matrix(white, [1, 1, 1])
    with pytest.raises(ArgumentError, match=r"target .* so far from white .* 'none'"):
        cat16_matrix([1, 1, 1], white)


@pytest.mark.parametrize(
    "white", [[np.nan, 1, 1], [np.inf, 1, 1], [1, 1], 1.0, np.ones((3, 3)), "D65", None]
)
def test_what_is_no_colour_is_refused(white):
    with pytest.raises(ArgumentError, match="white must be"):
        cat16_matrix(white, [1, 1, 1])


def test_no_eye_adapts_to_a_laser():
    refused = 0
    for xyz in colour_matching_functions(np.arange(400.0, 701.0)):
        try:
            matrix = cat16_matrix(xyz, SRGB.white)
        except ArgumentError:
            refused += 1
        else:
            assert np.abs(matrix).max() < 1e4
            assert_allclose(matrix @ xyz, SRGB.white, rtol=1e-10)
    assert refused > 150


def test_extreme_whites_give_a_finite_matrix_or_one_error():
    rng = np.random.default_rng(1)
    given = 0
    for _ in range(2000):
        white = 10.0 ** rng.uniform(-8, 8, 3) * rng.choice([-1, 1], 3, p=[0.1, 0.9])
        try:
            matrix = cat16_matrix(white, SRGB.white)
        except ArgumentError:
            continue
        given += 1
        assert_allclose(matrix @ white, SRGB.white, rtol=1e-9)
    assert given > 20


def test_the_responses_are_those_published():
    # Li et al. (2017): rows add to the response to equal energy, about 1.
    assert_allclose(CAT16.sum(axis=1), 1, atol=1e-6)
    assert_allclose(BRADFORD.sum(axis=1), 1, atol=1e-3)
