"""Plans: the order of steps, and the files that people write."""

import pytest

from skinviz.errors import ArgumentError, DataError
from skinviz.instruments.plan import AFTER, BEFORE, Plan
from skinviz.instruments.plan_file import read_plan


def test_white_stands_before_and_after_all_sites():
    plan = Plan(
        sites=("cheek", "arm"), illumination=(0.0, 30.0), viewing=60, states=("s", "p")
    )
    sweeps = [step.sweep for step in plan.steps]
    assert list(dict.fromkeys(sweeps)) == [BEFORE, "cheek", "arm", AFTER]
    assert [step.number for step in plan.steps] == list(range(len(sweeps)))
    cheek = [s.arrangement for s in plan.steps if s.sweep == "cheek"]
    assert [(a.state, a.illumination, a.lamp) for a in cheek] == [
        ("s", 0, False),
        ("s", 0, True),
        ("s", 30, True),
        ("p", 30, False),
        ("p", 30, True),
        ("p", 0, True),
    ]
    assert {a.target for a in cheek} == {"sample"}
    assert all(s.arrangement.lamp for s in plan.steps if s.sweep == AFTER)


def test_a_plan_is_kept_as_it_is():
    plan = Plan(sites=("cheek",), illumination=(0.0, 30.0), repeats=3, n=1.45)
    assert Plan.from_json(plan.to_json()) == plan
    with pytest.raises(ArgumentError, match="later version"):
        Plan.from_json(plan.to_json() | {"humidity": 3})


@pytest.mark.parametrize(
    ("fields", "told"),
    [
        ({"sites": ()}, "sites"),
        ({"sites": ("a", "a")}, "sites"),
        ({"sites": (AFTER,)}, "called"),
        ({"illumination": (90.0,)}, "85"),
        ({"states": ("crossed", "q")}, "choose one of"),
        ({"states": ("s", "p"), "illumination": (0.0,)}, "apart at 0/0"),
        ({"repeats": 1}, "repeats"),
        ({"average": 0}, "average"),
        ({"leakage": 1}, "leakage"),
        ({"illumination": tuple(range(85)), "repeats": 1000}, "too many"),
    ],
)
def test_plans_that_cannot_be_measured_are_refused(fields, told):
    with pytest.raises(ArgumentError, match=told):
        Plan(**fields)


def _read(tmp_path, text):
    path = tmp_path / "plan.toml"
    path.write_text(text, "utf-8")
    return read_plan(path)


def test_a_plan_is_read_from_toml(tmp_path):
    plan, white = _read(
        tmp_path,
        """
        [session]
        subject = "P07"
        sites = ["cheek", "back of hand"]
        white = "tile.csv"
        [geometry]
        illumination = {from = 0, to = 85, step = 5}
        viewing = 60
        states = ["s", "p"]
        [readings]
        repeats = 3
        sync = true
        [skin]
        n = 1.45
        """,
    )
    assert white == tmp_path / "tile.csv"
    assert plan.illumination == tuple(range(0, 86, 5))
    assert (plan.subject, plan.viewing, plan.n) == ("P07", 60, 1.45)
    assert (plan.repeats, plan.sync, plan.ambient) == (3, True, True)
    listed, nowhere = _read(tmp_path, "[geometry]\nillumination = [-30, 0.5]")
    assert listed.illumination == (-30, 0.5)
    assert nowhere is None


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[session", "not a TOML"),
        ("[sesion]", "session"),
        ("session = 3", r"\[session\]"),
        ("[session]\nsubjet = 'x'", "subject"),
        ("[session]\nsubject = 3", "must be text"),
        ("[session]\nsites = [3]", "list of texts"),
        ("[readings]\nrepeats = 2.5", "whole number"),
        ("[readings]\nrepeats = true", "whole number"),
        ("[readings]\nambient = 1", "true or false"),
        ("[geometry]\nillumination = 45", "from, to, step"),
        ("[geometry]\nillumination = {from = 0, to = 85}", r"step\}; got \{'from': 0"),
        ("[geometry]\nillumination = {from = 0, to = 85, step = 0}", "from, to, step"),
        ("[geometry]\nillumination = {from = 0, to = 8, step = nan}", "from, to, step"),
        ("[geometry]\nillumination = [true]", r"step\}; got \[True\]"),
        ("[geometry]\nillumination = [nan]", "illumination"),
        ("[geometry]\nillumination = [89]", "85"),
    ],
)
def test_files_that_are_no_plan_are_refused_by_name(tmp_path, text, told):
    with pytest.raises(DataError, match=told) as caught:
        _read(tmp_path, text)
    assert "plan.toml" in str(caught.value)
