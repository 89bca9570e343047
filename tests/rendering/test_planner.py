"""Plans keep what they were asked to keep, say what they leave out, and save."""

import dataclasses
import json

import numpy as np
import pytest
from planned_scenes import RATES, SCENES, hand, mapped, under_a_roof

from meshes import plane
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    TorranceSparrow,
    geometry_of,
    plan,
    render,
)
from skinviz.errors import ArgumentError
from skinviz.rendering import planner
from skinviz.rendering.files import read_picture_metadata
from skinviz.rendering.knobs import KNOBS
from skinviz.rendering.plan import SPECTRA
from skinviz.rendering.spectral import white_xyz
from skinviz.rendering.stage import stage_of
from skinviz.rendering.tolerance import FEW, compare
from skinviz.rendering.trial import Trial
from skinviz.rendering.work import work_of
from skinviz.surface.dispersion import dispersion

NAMES = [knob.name for knob in KNOBS]
TOLERANCES = (0.2, 1.0, 2.0)
FINGERS = [0.0, 0.0, 1.0]


@dataclasses.dataclass(frozen=True)
class Case:
    """A scene, its reference, and its picture at each tolerance."""

    scene: object
    reference: object
    pictures: dict


@pytest.fixture(scope="module", params=SCENES)
def case(request, model, steady):
    scene = SCENES[request.param](model)
    geometry = geometry_of(scene.mesh)
    pictures = {t: render(scene, tolerance=t, geometry=geometry) for t in TOLERANCES}
    return Case(scene, render(scene, Plan(), geometry=geometry), pictures)


def difference(case, picture):
    reference = case.reference
    return compare(picture.xyz, reference.xyz, reference.covered, white_xyz(case.scene))


def test_tolerances_are_kept(case):
    for tolerance, picture in case.pictures.items():
        found = difference(case, picture)
        assert found.kept(tolerance), (tolerance, found)


def test_looser_tolerances_never_cost_more(case, steady):
    costs = [
        cost_by_rates(case.scene, picture, steady) for picture in case.pictures.values()
    ]
    assert costs == sorted(costs, reverse=True)
    assert costs[0] <= cost_by_rates(case.scene, case.reference, steady)


def cost_by_rates(scene, picture, rates):
    """What a picture's plan costs by its own rays and some machine's rates. [ns]"""
    work, own = work_of(stage_of(scene)), picture.plan
    if own.refine is not None:
        even = ~stage_of(scene).sight.outlines & (picture.rays == 16)
        few = max(work.pixels - work.outlined, 1.0)
        work.rough[own.samples, own.refine] = even.sum() / (work.share * few)
    return sum(knob.cost(own, work, rates) for knob in KNOBS)


def test_findings_tell_every_knob(case):
    for tolerance, picture in case.pictures.items():
        own = picture.plan
        assert own.tolerance == tolerance
        found = {finding.knob: finding for finding in own.findings}
        assert [f.knob for f in own.findings][: len(NAMES)] == NAMES
        for knob in KNOBS:
            finding = found[knob.name]
            assert finding.saved >= 0
            assert (finding.left_out == "") == (knob.beyond(own) == "")
            if finding.left_out:
                assert 0 <= finding.delta_e < np.inf
            elif finding.delta_e is not None:
                assert finding.delta_e == 0
            if knob.share is not None and finding.left_out:
                assert finding.delta_e <= knob.share * tolerance


def test_what_differs_from_the_reference_is_told_as_left_out(case):
    for picture in case.pictures.values():
        for knob in KNOBS:
            if not knob.beyond(picture.plan):
                # Then, and only then, is the knob's setting the reference's.
                work = work_of(stage_of(case.scene))
                told = knob.told(picture.plan, work)
                exact = picture.plan.replace(**knob.levels(work)[-1])
                assert told == knob.told(exact, work)


def test_pictures_are_checked_where_something_was_left_out(case):
    for tolerance, picture in case.pictures.items():
        own = picture.plan
        checks = [f for f in own.findings if f.knob == "check"]
        large = picture.rays.sum(dtype=int) >= 320_000
        assert len(checks) == (own.samples < 16 and large)
        assert all(0 <= check.delta_e <= tolerance for check in checks)


def test_a_large_picture_tells_of_its_check(model, steady):
    picture = render(hand(model, camera=LARGE), tolerance=1.0)
    assert picture.plan.samples < 16
    *_, last = picture.plan.findings
    assert last.knob == "check"
    assert 0 <= last.delta_e <= 1


def test_the_table_of_findings_lines_up(case):
    for tolerance, picture in case.pictures.items():
        title, head, *rows = picture.plan.explain().splitlines()
        assert title == f"tolerance ΔE00 {tolerance:g}"
        assert len(rows) == len(picture.plan.findings)
        for name in ("chosen", "left out", "too coarse"):
            at = head.index(name)
            for row in rows:
                assert row[at - 2 : at].strip() == ""
                assert len(row) <= at or row[at] != " "
        for name in ("ΔE00", "saved"):
            end = head.index(name) + len(name)
            for row in rows:
                assert row[end - 1] != " "
                assert row[end : end + 2].strip() == ""
        for row, finding in zip(rows, picture.plan.findings, strict=True):
            assert row.startswith(finding.knob)
            assert finding.chosen in row
            assert row == row.rstrip()


def test_plans_are_kept_as_json_in_results(case):
    for picture in case.pictures.values():
        told = json.loads(json.dumps(dataclasses.asdict(picture.plan)))
        assert json.loads(json.dumps(picture.metadata["plan"])) == told
        assert len(told["findings"]) == len(picture.plan.findings)
        assert told["tolerance"] == picture.plan.tolerance


# One scene is enough ------------------------------------------------------------


def test_a_plan_goes_into_a_picture_file(model, steady, tmp_path):
    picture = render(hand(model), tolerance=1.0)
    file = picture.save(tmp_path / "hand.png")
    told = read_picture_metadata(file)["plan"]
    assert told == json.loads(json.dumps(dataclasses.asdict(picture.plan)))
    assert told["findings"][0]["knob"] == NAMES[0]


def test_the_same_scene_has_the_same_plan(model, steady):
    scene = mapped(model)
    first = plan(scene, 1.0)
    assert plan(scene, 1.0) == first
    assert plan(scene, 1.0, geometry=geometry_of(scene.mesh)) == first


def test_a_plan_draws_the_picture_that_is_drawn_by_its_tolerance(model, steady):
    scene = hand(model)
    planned = plan(scene, 1.0)
    ours, expected = render(scene, planned), render(scene, tolerance=1.0)
    assert planned.samples < 16
    np.testing.assert_array_equal(ours.xyz, expected.xyz)
    np.testing.assert_array_equal(ours.rays, expected.rays)


def test_the_tolerance_is_one_unless_it_is_said(model, steady):
    scene = hand(model)
    assert plan(scene) == plan(scene, 1.0)
    assert render(scene).plan.tolerance == 1.0


@pytest.mark.parametrize(
    "tolerance", [0, -1, 0.0099, 100.1, np.nan, np.inf, "1", None, True, [1.0]]
)
def test_what_is_no_tolerance_is_refused_by_name(model, steady, tolerance):
    scene = hand(model)
    with pytest.raises(ArgumentError, match="tolerance"):
        plan(scene, tolerance)
    with pytest.raises(ArgumentError, match="tolerance"):
        render(scene, tolerance=tolerance)


@pytest.mark.parametrize("tolerance", [0.01, 100.0])
def test_the_tightest_and_the_loosest_tolerance_are_kept(model, steady, tolerance):
    scene = hand(model, camera=Camera([0.2, 1, 0.1], FINGERS, (120, 120)))
    reference = render(scene, Plan())
    picture = render(scene, tolerance=tolerance)
    found = compare(picture.xyz, reference.xyz, reference.covered, white_xyz(scene))
    assert found.kept(tolerance)


@pytest.mark.parametrize("size", [(1, 1), (1, 40), (3, 2)])
def test_pictures_of_few_pixels_are_the_reference(model, steady, size):
    scene = hand(model, camera=Camera([0.2, 1, 0.1], FINGERS, size))
    picture, reference = render(scene, tolerance=0.5), render(scene, Plan())
    np.testing.assert_allclose(picture.xyz, reference.xyz, rtol=1e-6)
    assert [f.knob for f in picture.plan.findings][: len(NAMES)] == NAMES


@pytest.mark.parametrize("size", [(20, 20), (400, 400)])
def test_a_picture_past_the_mesh_has_a_plan(model, steady, size):
    camera = Camera([0.2, 1, 0.1], FINGERS, size, target=[5000, 0, 0], height=10.0)
    with pytest.warns(UserWarning, match="no ray meets the mesh"):
        picture = render(hand(model, camera=camera))
    assert [f.knob for f in picture.plan.findings][: len(NAMES)] == NAMES
    assert not picture.covered.any()


@pytest.mark.parametrize("side", [-1, 1])
def test_a_sheet_that_shows_no_lit_side_is_black(model, steady, side):
    # From behind, whose rays meet no outside, and from before with the light behind.
    camera = Camera([0, 0.3, side], [0, 1, 0], (300, 300))
    light = DirectionalLight([0, 0.2, -1])
    scene = hand(model, mesh=plane(9), camera=camera, lights=(light,))
    with pytest.warns(UserWarning, match="light 1 is behind|inside of the mesh"):
        picture = render(scene, tolerance=1.0)
    assert not picture.xyz.any()
    assert (picture.covered == 16).sum() > 1000


def test_few_filled_pixels_are_judged_by_the_largest_difference(model, steady):
    # At rates at which so small a picture is worth a plan.
    slow = dataclasses.replace(steady, band=3000.0)
    scene = mapped(model, camera=Camera([0.2, 1, 0.1], FINGERS, (48, 48)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(planner, "machine_rates", lambda: slow)
        picture = render(scene, tolerance=1.0)
    reference = render(scene, Plan())
    found = compare(picture.xyz, reference.xyz, reference.covered, white_xyz(scene))
    assert found.n_filled < FEW
    assert picture.plan.spectrum != "1 nm"
    assert found.most_filled <= 1.0
    assert found.kept(1.0)


# What is left out, and what is not ----------------------------------------------


LARGE = Camera([0.2, 1.0, 0.1], FINGERS, (1024, 1024))
"""So many pixels that finding out is worth it."""


def finding(planned, name):
    (own,) = [f for f in planned.findings if f.knob == name]
    return own


def test_a_shadow_that_is_seen_is_cast(model, steady):
    camera = Camera([0.7, 0, 1], [0, 1, 0], LARGE.size)
    planned = plan(under_a_roof(model).replace(camera=camera), 1.0)
    assert planned.shadows
    told = finding(planned, "shadows")
    assert told.refused == "none"
    assert told.refused_delta_e > 10


@pytest.mark.parametrize("tolerance", [0.2, 1.0])
def test_light_from_the_eye_casts_no_shadow_that_is_seen(model, steady, tolerance):
    scene = hand(model, camera=LARGE, lights=(DirectionalLight(LARGE.direction),))
    planned = plan(scene, tolerance)
    assert not planned.shadows
    told = finding(planned, "shadows")
    assert told.left_out == "cast shadows"
    assert told.delta_e == 0
    assert told.saved > 1


@pytest.fixture
def slow_lobes(steady, monkeypatch):
    """A machine on which the surface's reflection is worth leaving out."""
    rates = dataclasses.replace(steady, point=400.0, index=4000.0)
    monkeypatch.setattr(planner, "machine_rates", lambda: rates)


def test_what_edges_do_not_bear_is_kept(model, steady, monkeypatch):
    # Nothing changes in filled pixels, but too much at edges.
    scene = hand(model, camera=LARGE, lights=(DirectionalLight(LARGE.direction),))
    for edge, kept in ((1.99, False), (2.01, True)):
        monkeypatch.setattr(Trial, "edge_difference", lambda *_, edge=edge: edge)
        planned = plan(scene, 1.0)
        assert planned.shadows == kept
    told = finding(planned, "shadows")
    assert (told.refused, told.refused_delta_e) == ("none, at edges", 2.01)


def test_gloss_that_is_seen_is_kept(model, slow_lobes):
    planned = plan(hand(model, camera=LARGE), 1.0)
    assert planned.specular == "dispersion"
    told = finding(planned, "specular")
    assert (told.left_out, told.refused) == ("", "none")
    assert told.refused_delta_e > 1


def test_a_surface_that_does_not_shine_has_no_specular_part(model, slow_lobes):
    surface = TorranceSparrow(specular_scale=0.0)
    planned = plan(hand(model, camera=LARGE, surface=surface), 0.2)
    assert planned.specular == "none"
    assert finding(planned, "specular").delta_e == 0


def test_dispersion_is_left_out_where_one_index_suffices(model, slow_lobes):
    surface = TorranceSparrow(n=dispersion("epidermis"))
    scene = hand(model, camera=LARGE, surface=surface)
    tight, loose = plan(scene, 0.2), plan(scene, 1.0)
    assert (tight.specular, loose.specular) == ("dispersion", "constant")
    refused = finding(tight, "specular")
    assert refused.refused == "one refractive index"
    assert 0.2 < refused.refused_delta_e <= 1
    assert finding(loose, "specular").left_out == "its dispersion"


def test_light_between_parts_is_left_out_where_it_is_little(model, steady):
    scene = hand(model, camera=LARGE, interreflection="diffuse")
    tight, loose = plan(scene, 0.5), plan(scene, 5.0)
    assert (tight.bounce_rays, loose.bounce_rays) == (256, 0)
    assert finding(loose, "bounce").left_out == "light between parts"
    assert 0.5 < finding(loose, "bounce").delta_e < 2


def test_maps_need_fewer_wavelengths_for_looser_tolerances(model, steady):
    scene = mapped(model, camera=Camera([0.2, 1, 0.1], FINGERS, (320, 320)))
    levels = [SPECTRA.index(plan(scene, t).spectrum) for t in (0.2, 1.0, 3.0)]
    assert levels == sorted(levels, reverse=True)
    assert levels[0] > levels[-1]


def test_uniform_skin_has_nothing_to_leave_out_of_its_spectra(model, steady):
    planned = plan(hand(model, camera=LARGE), 5.0)
    assert planned.spectrum == "1 nm"
    assert planned.reflectance == "model"
    assert planned.arithmetic == "double"
    for name in ("spectrum", "reflectance", "arithmetic", "bounce"):
        told = finding(planned, name)
        assert (told.left_out, told.saved, told.refused) == ("", 0, "")
        assert told.delta_e == 0


@pytest.mark.parametrize("slow", ["ray", "band"])
def test_what_costs_nothing_is_not_left_out(model, slow):
    # Where only one kind of work takes time, only that is saved.
    none = dict.fromkeys(dataclasses.asdict(RATES), 1e-3)
    rates = dataclasses.replace(RATES, **{**none, slow: 200.0})
    scene = mapped(model, camera=Camera([0.2, 1, 0.1], FINGERS, (320, 320)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(planner, "machine_rates", lambda: rates)
        planned = plan(scene, 3.0)
    assert planned.shadows
    if slow == "band":
        assert planned.spectrum != "1 nm" or planned.reflectance != "model"
    else:
        assert planned.spectrum == "1 nm"
        assert planned.reflectance == "model"
        assert planned.samples < 16 or not planned.shadows
