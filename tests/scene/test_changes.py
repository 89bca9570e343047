"""What if there were more or less of something: one grammar, physical bounds."""

import numpy as np
import pytest

from skinviz import Skin, skin_model
from skinviz.errors import ArgumentError

UNIFORM = [0.1, 0.006, 0.002]
MAP = [[0.1, 0.006, 0.002], [0.2, 0.0, 0.0], [0.05, 0.0, 0.01]]


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"melanin": "x2"}, [0.2, 0.006, 0.002]),
        ({"melanin": "×2"}, [0.2, 0.006, 0.002]),
        ({"melanin": "+0.05"}, [0.15, 0.006, 0.002]),
        ({"melanin": "-0.05"}, [0.05, 0.006, 0.002]),
        ({"melanin": "0.3"}, [0.3, 0.006, 0.002]),
        ({"melanin": 0.3}, [0.3, 0.006, 0.002]),
        ({"melanin": "1e-1"}, [0.1, 0.006, 0.002]),
        ({"melanin": "x0"}, [0.0, 0.006, 0.002]),
        ({"oxyhaemoglobin": "x1.5"}, [0.1, 0.009, 0.002]),
        ({"deoxyhaemoglobin": "+0.001"}, [0.1, 0.006, 0.003]),
        ({"haemoglobin": "x2"}, [0.1, 0.012, 0.004]),
        ({"haemoglobin": "+0.008"}, [0.1, 0.012, 0.004]),
        ({"saturation": 0.5}, [0.1, 0.004, 0.004]),
        ({"saturation": "x0.5"}, [0.1, 0.003, 0.005]),
        ({"saturation": "-0.25"}, [0.1, 0.004, 0.004]),
        ({"saturation": 0.5, "haemoglobin": "x2"}, [0.1, 0.008, 0.008]),
        ({"saturation": 0.0, "oxyhaemoglobin": "x3"}, [0.1, 0.0, 0.02]),
    ],
)
def test_the_grammar_says_what_becomes_of_weights(model, changes, expected):
    skin = Skin(model, UNIFORM)
    np.testing.assert_allclose(skin.changed(**changes).values, expected, rtol=1e-14)
    np.testing.assert_array_equal(skin.values, UNIFORM)


def test_a_map_is_changed_at_every_vertex(model):
    changed = Skin(model, MAP).changed(melanin="x2", saturation=0.25)
    blood = np.array(MAP)[:, 1:].sum(axis=1)
    np.testing.assert_allclose(changed.values[:, 0], 2 * np.array(MAP)[:, 0])
    np.testing.assert_allclose(changed.values[:, 1:].sum(axis=1), blood, rtol=1e-14)
    np.testing.assert_allclose(changed.values[:, 1], 0.25 * blood, rtol=1e-14)


def test_the_skin_remembers_what_was_changed(model):
    skin = Skin(model, UNIFORM).changed(saturation=0.4, melanin="×2")
    assert skin.history == ("changed: melanin x2, saturation 0.4",)
    assert skin.changed(melanin="+0.1").history[1] == "changed: melanin +0.1"
    assert skin.changed() is skin


def test_parameters_that_are_no_pigments_stay():
    model = skin_model("lambert-beer", site="cheek", specular="included")
    skin = Skin(model, [0.1, 0.01, 0.01, 0.3])
    assert skin.changed(melanin="x2").values.tolist() == [0.2, 0.01, 0.01, 0.3]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"melanin": "2x"}, "x2 .to multiply"),
        ({"melanin": "twice"}, "got 'twice'"),
        ({"melanin": "x-2"}, "x2 .to multiply"),
        ({"melanin": "x"}, "x2 .to multiply"),
        ({"melanin": ""}, "x2 .to multiply"),
        ({"melanin": True}, "got True"),
        ({"melanin": None}, "got None"),
        ({"melanin": float("nan")}, "got nan"),
        ({"melanin": "x1e999"}, "finite"),
        ({"melanin": "-0.2"}, "makes w_m -0.1"),
        ({"melanin": "x1e14"}, "between 0 and 1e.12"),
        ({"saturation": 1.5}, "within 0 and 1"),
        ({"saturation": "-0.9"}, "within 0 and 1; the change makes it -0.15"),
        ({"melamin": "x2"}, "did you mean 'melanin'"),
    ],
)
def test_what_no_skin_has_is_refused(model, changes, message):
    with pytest.raises(ArgumentError, match=message):
        Skin(model, UNIFORM).changed(**changes)
