"""The figure of speed against accuracy: right data, every word readable."""

import dataclasses
import itertools

import numpy as np
import pytest
from drawn_texts import check_apart, check_inside, texts_of

from skinviz.rendering.knobs import KNOBS
from skinviz.rendering.plan import Plan
from skinviz.rendering.tolerance import Difference
from skinviz.rendering.tradeoff import Trade
from skinviz.rendering.ways import (
    GRID,
    ONE_KNOB,
    PLAIN,
    PLAIN_WAY,
    REFERENCE,
    TOLERANCE,
    UNIFORM,
    Way,
)
from skinviz.view.tradeoff_figure import tradeoff_figure

TITLE = "Speed against accuracy: a scene of a rather long name.toml, 512 × 512 pixels"
CAPTION = "machine: a machine of 2 processors. " * 6
TOLERANCES = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)


def trade(way, ms, error, edge=0.0):
    """A way with errors that are multiples of one."""
    off = Difference(error, edge, 4 * error, 4 * edge, 5000, 200, 0.0)
    return Trade(way, ms, off, error / 100)


def made(seed, fastest, slowest, least, most):
    """Ways of all groups, with times and errors within limits."""
    rng = np.random.default_rng(seed)

    def between(low, high):
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    def drawn(way, edge=0.0):
        return trade(way, between(fastest, slowest), between(least, most), edge)

    planned = [
        drawn(Way(TOLERANCE, f"ΔE00 {t:g}", Plan(tolerance=t), t, 0.3 * fastest))
        for t in TOLERANCES
    ]
    return [
        trade(Way(REFERENCE, "everything", Plan()), slowest, 0.0),
        drawn(Way(PLAIN_WAY, "plain", PLAIN), 20.0),
        *(drawn(Way(UNIFORM, str(n), Plan(samples=n)), 9.0) for n in (1, 2, 4, 8)),
        *(drawn(Way(ONE_KNOB, f"{knob.name}: less", Plan())) for knob in KNOBS),
        *planned,
        *(drawn(Way(GRID, "some", Plan())) for _ in range(20)),
        Trade(Way(ONE_KNOB, "spectrum: none", Plan()), note="cannot be had"),
    ]


def check_words(trades, title=TITLE, caption=CAPTION):
    figure = tradeoff_figure(trades, title, caption)
    texts = texts_of(figure)
    check_inside(figure, texts)
    check_apart(texts)
    return figure, "\n".join(text for text, _ in texts)


@pytest.mark.parametrize(
    ("times", "errors"),
    [
        *itertools.product(
            [(0.001, 0.0011), (80.0, 700.0), (2e4, 2.1e4), (0.5, 5e5)],
            [(1e-9, 1e-8), (0.011, 4.0), (0.9, 1.1), (1e-4, 120.0)],
        )
    ],
)
def test_every_word_can_be_read(times, errors):
    _, words = check_words(made(0, *times, *errors))
    for knob in KNOBS:
        if knob.name != "basis":
            assert knob.name in words
    assert "time of a picture (ms)" in words
    assert "spectral RMSE (share of white)" in words
    assert all(f"$ {tolerance:g}" in words for tolerance in TOLERANCES)


@pytest.mark.parametrize("title", ["short", "a title that goes on " * 12])
@pytest.mark.parametrize("caption", ["short", "what was measured where " * 40])
def test_titles_and_captions_are_wrapped(title, caption):
    check_words(made(1, 80.0, 700.0, 0.01, 3.0), title, caption)


def test_a_reference_alone_is_a_figure():
    check_words([trade(Way(REFERENCE, "everything", Plan()), 9.0, 0.0)])


def test_spectra_that_cannot_be_had_are_told():
    trades = [
        dataclasses.replace(t, spectral_rmse=None)
        for t in made(2, 80.0, 700.0, 0.01, 3.0)
    ]
    _, words = check_words(trades)
    assert "cannot be had" in words


def marks_of(axes):
    """Every mark of one point that a panel shows."""
    points = [line.get_xydata() for line in axes.lines if line.get_marker() != "None"]
    return {tuple(np.round(xy, 9)) for xy in np.concatenate(points)}


def test_marks_are_the_data():
    trades = made(3, 80.0, 700.0, 0.01, 3.0)
    figure, _ = check_words(trades)
    panels = figure.axes[:3]
    for i, own in enumerate(trades[1:-1]):
        off = own.difference
        for axes, value in zip(
            panels, (off.filled, off.most_filled, own.spectral_rmse), strict=True
        ):
            assert tuple(np.round((own.ms, value), 9)) in marks_of(axes), i
    for axes in panels:
        (low, high), (left, right) = axes.get_ylim(), axes.get_xlim()
        for x, y in marks_of(axes):
            assert low <= y <= high
            assert left <= x <= right


def test_the_front_has_every_way_that_keeps_its_edges_on_or_above_it():
    trades = made(4, 80.0, 700.0, 0.01, 3.0)
    figure, _ = check_words(trades)
    (stairs,) = (
        line for line in figure.axes[0].lines if line.get_drawstyle() == "steps-post"
    )
    x, y = stairs.get_data()
    for own in trades:
        if own.edges_kept and own.difference.filled > 0:
            before = np.flatnonzero(x <= own.ms)
            assert before.size
            assert y[before[-1]] <= own.difference.filled


def test_what_does_not_keep_its_edges_is_pale():
    trades = made(5, 80.0, 700.0, 0.01, 3.0)
    figure, _ = check_words(trades)
    plain = trades[1]
    (mark,) = (
        line
        for line in figure.axes[0].lines
        if line.get_xdata().size == 1 and line.get_xdata()[0] == plain.ms
    )
    assert mark.get_alpha() < 0.5
