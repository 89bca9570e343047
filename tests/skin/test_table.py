"""A table of a model's light: exact at nodes, bounded between them, told outside."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from tolerances import ROUNDING

from skinviz import ArgumentError, skin_model
from skinviz.skin.table import SAFETY, ReflectanceTable, reflectance_table
from skinviz.spectra.colorimetry import xyz_weights
from skinviz.spectra.illuminants import illuminant_spd

NM = np.linspace(430.0, 670.0, 8)
XYZ = xyz_weights(NM, illuminant_spd("D65", NM))
USUAL = {
    "w_m": (0.0, 0.4),
    "w_h": (0.0, 0.03),
    "w_dh": (0.0, 0.02),
    "offset": (0.1, 0.8),
    "scattering": (0.7, 1.5),
    "melanin_slope": (-0.5, 1.0),
    "epidermis": (0.8, 1.2),
}
SITE = {"thickness": (0.035, 1.19), "specular": "included"}
TWO_LAYER = skin_model("two-layer", **SITE)
MODELS = {
    "two-layer": TWO_LAYER,
    "bare": skin_model("two-layer", thickness=(0.1, 3.0), specular="excluded"),
    "cotton": skin_model("cotton", **SITE),
    "lambert-beer": skin_model("lambert-beer", **SITE),
    "extended": skin_model("extended", free=("scattering",), **SITE),
    "thickness": skin_model("extended", free=("epidermis",), **SITE),
}


def box(skin):
    """Return the corners of what skin usually has."""
    return np.array([USUAL[p.name] for p in skin.parameters]).T


def dense(low, high, n, seed=1):
    """Return places, half even over the box, half closer to its low corner."""
    x = np.random.default_rng(seed).uniform(size=(n, len(low)))
    x[::2] = 10 ** (-18 * x[::2] if np.max(high) > 1e3 else -5 * x[::2])
    return np.clip(low + (np.asarray(high) - low) * x, low, high)


def largest_error(table, skin, values, nm=NM, weights=XYZ):
    """Return the largest error of each channel at the values."""
    exact = skin.diffuse(values, nm) @ weights
    return np.abs(table.at(values) - exact).max(axis=0)


def nodes_of(table):
    """Return the parameters at the nodes, flat, in the order of the entries."""
    columns = [np.array([low]) for low in table.low]
    for axis in table.axes:
        columns[axis.column] = axis.nodes
    return np.stack(np.meshgrid(*columns, indexing="ij"), -1).reshape(-1, len(columns))


@pytest.mark.parametrize("name", MODELS)
def test_it_is_the_model_at_the_nodes(name):
    skin = MODELS[name]
    table = reflectance_table(skin, *box(skin), NM, XYZ, tolerance=1e-2)
    nodes = nodes_of(table)
    assert table.size == len(nodes)
    exact = skin.diffuse(nodes, NM) @ XYZ
    assert_allclose(table.entries.reshape(-1, 3), exact, rtol=ROUNDING)
    assert_allclose(table.at(nodes), exact, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("tolerance", [1e-2, 3e-4])
def test_the_error_it_states_is_kept_and_no_larger_than_asked(name, tolerance):
    skin = MODELS[name]
    table = reflectance_table(skin, *box(skin), NM, XYZ, tolerance=tolerance)
    assert (table.error <= tolerance).all()
    found = largest_error(table, skin, dense(*box(skin), 30_000))
    assert (found <= table.error).all()
    assert (found >= table.error / (3 * SAFETY)).any()  # it says what it is, not more


@pytest.mark.parametrize(
    ("low", "high"),
    [
        ((0, 0, 0), (1e12, 1e12, 1e12)),
        ((0, 0, 0), (1e3, 1.0, 1e-9)),
        ((1e11, 0, 1e-3), (1e12, 1e-12, 1e-2)),
        ((0.05, 2e-3, 1e-3), (0.4, 0.03, 0.02)),
        ((0.1, 0, 0.004), (0.1, 0.05, 0.004)),
        ((0, 0, 0), (5e-324, 1e-300, 0.02)),
    ],
)
def test_boxes_of_all_sizes_keep_it(low, high):
    table = reflectance_table(TWO_LAYER, low, high, NM, XYZ, tolerance=3e-3)
    assert (table.error <= 3e-3).all()
    found = largest_error(table, TWO_LAYER, dense(np.array(low), high, 40_000))
    assert (found <= table.error).all()


def test_the_error_falls_with_the_fourth_power_of_the_nodes_along_an_axis():
    low, high = (0.05, 0.008, 0.004), (0.3, 0.008, 0.004)
    values = dense(np.array(low), high, 5000)
    cells, errors = [], []
    for tolerance in (1e-5, 1e-9):
        table = reflectance_table(TWO_LAYER, low, high, NM, XYZ, tolerance=tolerance)
        cells.append(table.axes[0].cells)
        errors.append(largest_error(table, TWO_LAYER, values).max())
    order = np.log(errors[0] / errors[1]) / np.log(cells[1] / cells[0])
    assert 3.5 < order < 4.5


def test_a_table_grows_as_the_tolerance_falls():
    tables = [
        reflectance_table(TWO_LAYER, *box(TWO_LAYER), NM, XYZ, tolerance=t)
        for t in (1e-2, 1e-3, 1e-4)
    ]
    assert tables[0].size < tables[1].size < tables[2].size < 4000
    assert (tables[0].error > tables[1].error).all()
    assert (tables[1].error > tables[2].error).all()


def test_the_channel_that_needs_most_decides():
    loose = reflectance_table(TWO_LAYER, *box(TWO_LAYER), NM, XYZ, tolerance=1e-2)
    tight = reflectance_table(
        TWO_LAYER, *box(TWO_LAYER), NM, XYZ, tolerance=[1e-2, 1e-2, 1e-4]
    )
    assert tight.error[2] <= 1e-4 < loose.error[2]
    assert tight.size > loose.size


def test_too_few_nodes_give_the_best_table_and_say_so():
    corners = box(TWO_LAYER)
    tables = [
        reflectance_table(TWO_LAYER, *corners, NM, XYZ, tolerance=1e-6, most=most)
        for most in (64, 500, 4000)
    ]
    values = dense(*corners, 30_000)
    for table, most in zip(tables, (64, 500, 4000), strict=True):
        assert table.size <= most
        assert (table.error > 1e-6).all()
        assert (largest_error(table, TWO_LAYER, values) <= table.error).all()
    assert tables[0].size == 64
    assert (tables[1].error < tables[0].error).all()
    assert (tables[2].error < tables[1].error).all()


def test_light_that_falls_without_bound_at_no_blood_is_told_honestly():
    # Over an endless dermis R is 1 − √(2K/S) at the least blood: no cubic follows it.
    skin = skin_model("two-layer", thickness=(0.035, np.inf), specular="excluded")
    table = reflectance_table(skin, *box(skin), NM, XYZ, tolerance=1e-4, most=20_000)
    assert (table.error > 1e-4).all()
    assert (largest_error(table, skin, dense(*box(skin), 30_000)) <= table.error).all()


def test_without_weights_it_holds_reflectances():
    plain = reflectance_table(TWO_LAYER, *box(TWO_LAYER), NM, tolerance=1e-3)
    values = dense(*box(TWO_LAYER), 5000)
    exact = TWO_LAYER.diffuse(values, NM)
    assert plain.error.shape == (8,)
    assert (np.abs(plain.at(values) - exact) <= plain.error).all()


def test_wavelengths_need_no_order_and_may_repeat():
    order = [5, 2, 7, 0, 2, 1]
    weights = np.random.default_rng(0).uniform(0, 1, (6, 2))
    mixed = reflectance_table(
        TWO_LAYER, *box(TWO_LAYER), NM[order], weights, tolerance=1e-3
    )
    values = dense(*box(TWO_LAYER), 5000)
    exact = TWO_LAYER.diffuse(values, NM)[:, order] @ weights
    assert (np.abs(mixed.at(values) - exact).max(axis=0) <= mixed.error).all()
    plain = reflectance_table(TWO_LAYER, *box(TWO_LAYER), NM[order], tolerance=1e-3)
    assert_array_equal(plain.at(values)[:, 1], plain.at(values)[:, 4])


def test_scaled_weights_scale_the_table():
    values = dense(*box(TWO_LAYER), 500)
    usual = reflectance_table(TWO_LAYER, *box(TWO_LAYER), NM, XYZ, tolerance=1e-3)
    for scale in (1e-30, 1e30):
        scaled = reflectance_table(
            TWO_LAYER, *box(TWO_LAYER), NM, XYZ * scale, tolerance=1e-3 * scale
        )
        assert scaled.size == usual.size
        assert_allclose(scaled.at(values) / scale, usual.at(values), rtol=1e-12)


def test_float32_differs_by_its_rounding():
    values = dense(*box(TWO_LAYER), 20_000)
    fine, coarse = (
        reflectance_table(
            TWO_LAYER, *box(TWO_LAYER), NM, XYZ, tolerance=1e-4, dtype=dtype
        )
        for dtype in (np.float64, np.float32)
    )
    assert coarse.entries.dtype == coarse.at(values).dtype == np.float32
    assert coarse.size == fine.size
    assert_allclose(coarse.at(values), fine.at(values), rtol=0, atol=1e-6)
    assert (largest_error(coarse, TWO_LAYER, values) <= coarse.error).all()


def test_float32_says_that_it_cannot_be_finer_than_its_rounding():
    table = reflectance_table(
        *(TWO_LAYER, (0.1, 0.01, 0.01), (0.2, 0.01, 0.01), NM, XYZ),
        tolerance=1e-12,
        most=100,
        dtype="float32",
    )
    assert (table.error > 1e-7).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_no_range_is_one_colour(dtype):
    own = np.array([0.1, 0.008, 0.004])
    table = reflectance_table(TWO_LAYER, own, own, NM, XYZ, tolerance=1e-5, dtype=dtype)
    assert (table.size, table.axes) == (1, ())
    exact = (TWO_LAYER.diffuse(own, NM) @ XYZ).astype(dtype)
    rounding = 4 * np.finfo(dtype).eps
    assert_allclose(table.at([own, own]), [exact, exact], rtol=rounding)
    with pytest.raises(ArgumentError, match=r"parameter 0 from 0\.1 to 0\.1"):
        table.at([[0.11, 0.008, 0.004]])


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_a_table_of_one_colour_reads_nothing_but_it(dtype):
    # What lies in memory after it is anything: here, no numbers.
    memory = np.full(64, np.nan, dtype)
    memory[:3] = 1, 2, 3
    one, error = np.array([0.1]), np.zeros(3)
    table = ReflectanceTable(one, one, (), memory[:3], error)
    assert_array_equal(table.at(np.tile(one, (5, 1))), np.tile(memory[:3], (5, 1)))


@pytest.mark.parametrize("m", [0, 1, 127, 128, 129, 30_000])
def test_any_number_of_points_is_looked_up_alike(m):
    table = reflectance_table(TWO_LAYER, *box(TWO_LAYER), NM, XYZ, tolerance=1e-3)
    values = dense(*box(TWO_LAYER), m)
    found = table.at(values)
    assert found.shape == (m, 3)
    for i in range(0, m, 997):
        assert_array_equal(table.at(values[i : i + 1])[0], found[i])


def test_it_writes_where_it_is_told_and_reads_what_may_only_be_read():
    table = reflectance_table(TWO_LAYER, *box(TWO_LAYER), NM, XYZ, tolerance=1e-3)
    values = dense(*box(TWO_LAYER), 300)
    values.setflags(write=False)
    out = np.full((300, 3), np.nan)
    assert table.at(values, out) is out
    assert_array_equal(out, table.at(np.asfortranarray(values)))
    for wrong in (out[:, :2], out.astype(np.float32), out[::2], np.asfortranarray(out)):
        with pytest.raises(ArgumentError, match="out must be a writeable"):
            table.at(values, wrong)


def test_all_six_parameters_at_once():
    skin = skin_model(
        "extended", free=("scattering", "melanin_slope", "epidermis"), **SITE
    )
    table = reflectance_table(skin, *box(skin), NM, XYZ, tolerance=1e-2)
    assert len(table.axes) == 6
    found = largest_error(table, skin, dense(*box(skin), 3000))
    assert (found <= table.error).all()


def test_values_outside_are_refused_beyond_rounding():
    low, high = (0.1, 0.001, 0.002), (0.3, 0.01, 0.002)
    table = reflectance_table(TWO_LAYER, low, high, NM, XYZ, tolerance=1e-3)
    rounded = np.nextafter([low, high], [np.zeros(3), np.ones(3)])
    assert_allclose(table.at(rounded), table.at([low, high]), rtol=ROUNDING)
    for column, value in ((0, 0.31), (0, -1.0), (1, np.nan), (2, np.inf), (2, 0.0)):
        values = np.tile(low, (200, 1))
        values[150, column] = value
        with pytest.raises(ArgumentError, match=f"parameter {column} .*row 150"):
            table.at(values)
    for shape in ((3,), (2, 4), (2, 2, 3)):
        with pytest.raises(ArgumentError, match=r"values must be \(m, 3\)"):
            table.at(np.full(shape, 0.1))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"low": (0.5, 0, 0)}, "low must not be above high; w_m is from 0.5 to 0.4"),
        ({"low": (-1, 0, 0)}, "w_m must be between"),
        ({"high": (np.nan, 1, 1)}, "w_m must be between"),
        ({"high": (1, 1)}, "takes 3 weights"),
        ({"low": np.zeros((1, 3))}, "one set of parameters each"),
        ({"wavelengths": []}, "1-D array of at least one value"),
        ({"wavelengths": np.full(8, np.nan)}, "finite"),
        ({"weights": XYZ[:5]}, r"weights must be \(8, channels\)"),
        ({"weights": XYZ[:, :0]}, r"weights must be \(8, channels\)"),
        ({"weights": XYZ[:, 0]}, r"weights must be \(8, channels\)"),
        ({"weights": np.full((8, 3), np.inf)}, "weights must be finite"),
        ({"tolerance": 0.0}, "tolerance must be > 0"),
        ({"tolerance": np.nan}, "tolerance must be > 0"),
        ({"tolerance": [1e-3, 1e-3]}, "tolerance must be one number or 3"),
        ({"most": 63}, "most must be at least 64 nodes"),
        ({"dtype": np.int64}, "dtype must be float64 or float32"),
        ({"dtype": np.float32, "weights": XYZ * 1e40}, "overflow float32"),
    ],
)
def test_what_it_cannot_do_it_says(changed, message):
    low, high = box(TWO_LAYER)
    given = {"low": low, "high": high, "wavelengths": NM, "weights": XYZ}
    given |= {"tolerance": 1e-2, **changed}
    with pytest.raises(ArgumentError, match=message):
        reflectance_table(TWO_LAYER, **given)
