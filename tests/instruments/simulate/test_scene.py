"""The simulated scene: what is known of it beforehand."""

import numpy as np
import pytest
from benches import GRID, NM, bench, skin, subject
from numpy.testing import assert_allclose, assert_array_equal

from skinviz.instruments.arrangement import Arrangement
from skinviz.instruments.simulate.optics import UNPOLARISED, polariser, reflection
from skinviz.instruments.simulate.scene import Lamp, QuickTime, halogen


def test_a_halogen_lamp_is_a_black_body():
    lamp = halogen(2856.0, 1.0)
    # Illuminant A's ratio of 560 to 780 nm, CIE 15.
    at = {nm: lamp.radiance[lamp.wavelengths == nm][0] for nm in (560.0, 780.0)}
    assert at[560.0] / at[780.0] == pytest.approx(100 / 241.675, rel=2e-3)


def test_a_lamp_warms_up_and_drifts():
    lamp = Lamp(NM, np.ones(NM.size), drift=-0.01, warm_up=0.02, settling=60.0)
    assert lamp.output(0.0) == pytest.approx(0.98)
    assert lamp.output(3600.0) == pytest.approx(0.99)


def test_radiance_falls_with_the_cosine_and_is_none_in_the_dark():
    on = bench(ambient=0.0)
    on.arrange(Arrangement("white", True, 0.0, 0.0, "open"))
    facing = on.radiance(NM)
    assert_allclose(facing, on.lamp.output(0) * on.lamp.radiance[:441] * on.tile[1])
    on.turn(60.0)
    assert_allclose(on.radiance(NM), facing / 2)
    on.arrange(Arrangement("white", False, 0.0, 0.0, "open"))
    assert not on.radiance(NM).any()


def test_skin_is_its_body_and_its_lobe():
    glossy = subject(lambda light, view: 0.001 * (light + 2 * view))
    on = bench(subject=glossy, ambient=0.0, grating=0.0)
    seen = {}
    for target in ("white", "sample"):
        on.arrange(Arrangement(target, True, 30.5, 20.25, "open"))
        seen[target] = on.radiance(NM)
    factor = seen["sample"] / seen["white"] * on.tile[1]
    expected = skin() + 0.001 * (30.5 + 40.5) / np.cos(np.deg2rad(30.5))
    assert_allclose(factor, expected, rtol=1e-12)


def test_noise_is_as_large_as_said_and_seeded():
    def readings(seed):
        on = bench(shot=0.004, read=0.0, seed=seed, exposure=0.0)
        return np.array([on.reading(GRID.wavelengths, 4) for _ in range(400)])

    seen = readings(1)
    brightest = seen.mean(axis=0).argmax()
    assert seen.std(axis=0)[brightest] / seen.mean(axis=0)[brightest] == pytest.approx(
        0.004 / 2, rel=0.1
    )
    assert_array_equal(seen, readings(1))
    assert (seen != readings(2)).any()


def test_quick_time_passes_only_when_something_takes_time():
    time = QuickTime()
    assert time.now() == time.now() == 0
    time.elapse(3.0)
    assert time.now() == 3


@pytest.mark.parametrize("azimuth", [0.0, 30.0, 90.0, 135.0])
def test_a_polariser_obeys_malus(azimuth):
    light = polariser(azimuth, 0.0) @ UNPOLARISED
    assert light[0] == pytest.approx(0.5)
    for turn in (0.0, 20.0, 90.0):
        seen = (polariser(azimuth + turn, 0.0) @ light)[0]
        assert seen == pytest.approx(0.5 * np.cos(np.deg2rad(turn)) ** 2, abs=1e-15)
    leaky = (polariser(azimuth + 90, 0.01) @ light)[0]
    assert leaky == pytest.approx(0.5 * 0.01)


def test_a_mirror_at_brewsters_angle_polarises_all():
    light = reflection(float(np.arctan(1.4)), 1.4) @ UNPOLARISED
    assert light[0] == pytest.approx(light[1])
