"""How findings are told: a line each, in columns, in as many digits as matter."""

import pytest

from skinviz import Plan
from skinviz.rendering.finding import Finding, told_table

SOME = (
    Finding("spectrum", "8 nodes", "the wavelengths between", 0.0123, 1234.4),
    Finding("basis", "spectra shared", "", 0.0, 0.4),
    Finding("shadows", "cast", "", None, 0.0, "none", 31.46),
    # Half a millisecond is rounded to none.
    Finding("specular", "none", "the surface's reflection", 9.9996, 0.5, "x", None),
)


def test_without_findings_it_says_that_nothing_was_planned():
    assert told_table(None, ()) == Plan().explain()
    assert "not planned" in Plan().explain()


def test_findings_are_told_in_columns():
    assert told_table(0.5, SOME).splitlines() == [
        "tolerance ΔE00 0.5",
        f"knob      chosen          left out{20 * ' '}ΔE00    saved  too coarse",
        "spectrum  8 nodes         the wavelengths between    0.012  1234 ms",
        "basis     spectra shared  nothing                        0        -",
        "shadows   cast            nothing                        -        -  none: 31",
        "specular  none            the surface's reflection  10.000        -  x",
    ]


@pytest.mark.parametrize(
    ("delta_e", "told"),
    [
        (0.0, "0"),
        (None, "-"),
        (1e-9, "0.000"),
        (0.12345, "0.123"),
        (9.99, "9.990"),
        (10.4, "10"),
        (float("inf"), "inf"),
    ],
)
def test_differences_have_as_many_digits_as_matter(delta_e, told):
    line = told_table(1.0, [Finding("knob", "some", "more", delta_e)]).splitlines()[-1]
    assert line.split()[-2] == told


def test_a_plan_tells_its_own_findings():
    plan = Plan(tolerance=0.25, findings=SOME)
    assert plan.explain() == told_table(0.25, SOME)
    assert plan.explain().startswith("tolerance ΔE00 0.25\n")
