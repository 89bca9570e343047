"""Tables of text: columns aligned, wrapped instead of running over the line."""

import pytest

from skinviz.cli.text_table import Column, table

PARAMETERS = [
    "w_m",
    "w_h",
    "w_dh",
    "scattering",
    "melanin_slope",
    "surface",
    "epidermis",
]


@pytest.mark.parametrize("n", range(3, 8))
@pytest.mark.parametrize("label", ["cheek", "UK3/1234 back of the left hand, repeated"])
def test_three_to_seven_parameters_fit_into_100_letters(n, label):
    columns = [
        Column(name, [f"{i}.1234"], [f"{i}.1000..{i}.2000"])
        for i, name in enumerate(PARAMETERS[:n])
    ]
    columns.append(Column("status", ["not_converged"]))
    lines = list(table("spectrum", [label], columns))
    assert max(map(len, lines)) <= 100
    text = "\n".join(lines)
    for word in (label, *PARAMETERS[:n], "not_converged"):
        assert word in text
    for i in range(n):
        assert text.index(f"{i}.1234") < text.index(f"{i}.1000..{i}.2000")


def test_a_cell_stands_under_its_name():
    rows = Column("w_m", ["0.1", "22.25"], ["", "20..30"])
    head, first, second, below = table("model", ["a", "bcdefg"], [rows])
    assert head.endswith("w_m")
    assert len(head) == len(first) == len(second) == len(below)
    assert second.startswith("bcdefg ")
