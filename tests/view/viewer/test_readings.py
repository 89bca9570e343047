"""Numbers at marked points are those of their pixels."""

import numpy as np
import pytest

from skinviz.view.viewer.readings import difference_of, mark_at, readings_of

SIZE = (60, 48)


def test_a_point_has_the_colour_of_its_pixel(marked):
    shown = marked(SIZE, (31, 22), (22, 30))
    for reading, (column, row) in zip(
        readings_of(shown), [(31, 22), (22, 30)], strict=True
    ):
        off = np.subtract(reading.rgb, shown.picture[row, column].astype(int))
        assert np.abs(off).max() <= 1
        assert reading.hex == "#{:02x}{:02x}{:02x}".format(*reading.rgb)
        at = reading.at[0] * SIZE[0], reading.at[1] * SIZE[1]
        assert int(at[0]) == column
        assert int(at[1]) == row


def test_lightness_counts_from_the_white_under_the_first_light(marked):
    shown = marked(SIZE, (31, 22))
    (reading,) = readings_of(shown)
    ratio = reading.xyz[1] / shown.stages[0].white[1]
    lightness = 116 * np.cbrt(ratio) - 16
    assert reading.lab[0] == pytest.approx(lightness, rel=1e-9)


def test_two_points_differ(marked):
    readings = readings_of(marked(SIZE, (31, 22), (22, 30)))
    assert difference_of(readings) > 0.1
    assert difference_of(readings[:1]) is None


def test_a_point_that_is_turned_away_is_out_of_sight(marked, darkroom):
    shown = marked(SIZE, (31, 22))
    away = shown.state.replace(view=(180.0, 0.0, 0.0))
    assert readings_of(darkroom.quick(away, SIZE)) == (None,)


def test_beside_the_mesh_there_is_no_point(opened, darkroom):
    assert mark_at(darkroom.quick(opened.initial, SIZE), 0, 0) is None


def test_on_the_map_there_is_no_point(opened, darkroom):
    state = opened.initial.with_hands(2).replace(difference=True)
    shown = darkroom.quick(state, (184, 48))
    left, _ = shown.tiles.corner(2)
    assert mark_at(shown, left + 30, 24) is None
    assert mark_at(shown, 30, 24) is not None
