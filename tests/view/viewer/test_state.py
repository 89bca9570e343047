"""States refuse what cannot be shown, and links hold them whole."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinviz.errors import ArgumentError
from skinviz.spectra.adaptation import ADAPTATIONS
from skinviz.surface.models import surface_models
from skinviz.view.viewer.address import LONGEST, from_query, to_query
from skinviz.view.viewer.history import History
from skinviz.view.viewer.state import Look, Mark, ViewState

angles = st.floats(-180, 180, allow_nan=False)
lengths = st.floats(-300, 300, allow_nan=False)
names = st.text(
    st.characters(exclude_characters="|", exclude_categories=["Cs"]), max_size=30
)
looks = st.builds(Look, names, names, st.lists(st.floats(0, 10), max_size=4).map(tuple))


@st.composite
def states(draw):
    shown = tuple(draw(looks) for _ in range(draw(st.sampled_from([1, 2, 4]))))
    hand = st.integers(0, len(shown) - 1)
    marks = st.builds(Mark, hand, st.tuples(lengths, lengths, lengths))
    return ViewState(
        looks=shown,
        active=draw(hand),
        difference=draw(st.booleans()),
        illuminant=draw(names),
        light=(draw(angles), draw(angles)),
        view=(draw(angles), draw(angles), draw(angles)),
        zoom=draw(st.floats(0.05, 100)),
        shift=(draw(lengths), draw(lengths)),
        surface=draw(st.sampled_from(surface_models())),
        width=draw(st.floats(0, 1e3)),
        index=draw(names),
        specular_scale=draw(st.floats(0, 10)),
        exposure=draw(st.floats(1e-3, 1e3)),
        white=draw(st.sampled_from(ADAPTATIONS)),
        tolerance=draw(st.floats(0.01, 100)),
        points=tuple(draw(st.lists(marks, max_size=2))),
    )


@given(states(), states())
def test_a_link_holds_the_whole_state(state, initial):
    assert from_query(to_query(state, initial), initial) == state


def test_the_first_state_has_no_query():
    assert to_query(ViewState(), ViewState()) == ""


@pytest.mark.parametrize(
    "query",
    [
        "zoom=nan",
        "zoom=1e999",
        "zoom=big",
        "view=1,2",
        "view=1,2,3,4",
        "light=400,0",
        "hand=a|b",
        "hand=a|b|x",
        "hand=a|b|nan",
        "hand=a|b|-1e99",
        "hand=||&hand=||&hand=||",
        "active=7",
        "active=-1",
        "difference=yes",
        "point=9,1,2,3",
        "point=0,1,2",
        "point=0,1,2,nan",
        "point=0,1,2,3&point=0,1,2,3&point=0,1,2,3",
        "surface=glass",
        "white=blue",
        "tolerance=0",
        "exposure=-1",
        "illuminant=" + "x" * 500,
        "nothing=1",
        "zoom=" + "1" * LONGEST,
    ],
)
def test_a_link_that_says_nonsense_is_refused_in_one_line(query):
    with pytest.raises(ArgumentError) as error:
        from_query(query, ViewState())
    assert str(error.value)


@pytest.mark.parametrize(
    "changes",
    [
        {"zoom": "1"},
        {"zoom": None},
        {"zoom": math.nan},
        {"difference": 1},
        {"active": 0.5},
        {"light": 3},
        {"light": ("a", 0)},
        {"illuminant": 5},
        {"looks": ()},
    ],
)
def test_values_of_other_kinds_are_refused(changes):
    with pytest.raises(ArgumentError):
        ViewState(**changes)


def test_fewer_hands_take_their_points_along():
    state = ViewState().with_hands(4).replace(active=3, difference=False)
    state = state.marking(Mark(0, (0.0, 0.0, 0.0)), second=False)
    state = state.marking(Mark(3, (1.0, 0.0, 0.0)), second=True)
    fewer = state.with_hands(2)
    assert fewer.active == 1
    assert [mark.look for mark in fewer.points] == [0]


def test_a_second_point_joins_the_first_and_a_first_replaces_both():
    first, other = Mark(0, (0.0, 0.0, 0.0)), Mark(0, (1.0, 0.0, 0.0))
    both = ViewState().marking(first, second=False).marking(other, second=True)
    assert both.points == (first, other)
    assert both.marking(other, second=False).points == (other,)


# Undo -----------------------------------------------------------------------


def zoomed(history, zoom, now):
    return history.changed(history.present.replace(zoom=zoom), now)


def test_undo_goes_back_and_redo_takes_it_again():
    first = History(ViewState())
    second = zoomed(first, 2.0, 10.0)
    third = second.changed(second.present.replace(exposure=2.0), 20.0)
    assert third.undone().present == second.present
    assert third.undone().undone().present == first.present
    assert third.undone().redone().present == third.present
    assert third.undone().redone().undone().present == second.present


def test_at_the_ends_nothing_happens():
    history = History(ViewState())
    assert history.undone() is history
    assert history.redone() is history


def test_a_drag_is_one_step():
    history = History(ViewState())
    for i in range(30):
        history = zoomed(history, 1.0 + 0.1 * (i + 1), 10.0 + 0.05 * i)
    assert history.undone().present == ViewState()
    later = zoomed(history, 9.0, 60.0)
    assert later.undone().present == history.present


def test_a_change_forgets_what_was_undone():
    history = zoomed(History(ViewState()), 2.0, 10.0).undone()
    assert zoomed(history, 3.0, 20.0).redone().present.zoom == 3.0


def test_the_list_of_undos_ends():
    history = History(ViewState())
    for i in range(1000):
        history = zoomed(history, 1.0 + 0.01 * (i + 1), 10.0 * i)
    assert len(history.past) <= 200
