"""Every figure of the gallery: readable at any size, and showing what it says."""

import dataclasses

import matplotlib as mpl
import numpy as np
import pytest
from drawn_texts import check_apart, check_inside, texts_of
from numpy.testing import assert_allclose

from skinviz import fit_skin, load_archive, skin_model
from skinviz.skin.coefficients import load_coefficients
from skinviz.spectra.archive_selection import average_repeats, select
from skinviz.spectra.colorimetry import delta_e_2000, spectrum_to_xyz
from skinviz.study.tables import SITES
from skinviz.view.gallery.catalogue import NAMES, recipe_of
from skinviz.view.gallery.metameric_lights import TRIPLES, white_lines
from skinviz.view.gallery.recipe import Settings
from skinviz.view.page import STYLE

DRAWN = [name for name in NAMES if recipe_of(name).draw is not None]
HANDS = ("8", "9", "10", "metameric-lights")


@pytest.mark.parametrize("share", [0.6, 1.0, 1.6])
@pytest.mark.parametrize("name", DRAWN)
def test_every_word_can_be_read(made, name, share):
    # What is drawn depends on the width, what it is drawn from does not.
    own = made(name, share if name in HANDS else 1.0)
    settings = Settings(recipe_of(name).width * share)
    with mpl.rc_context(STYLE):
        figure = own.recipe.draw(own.material, settings)
        texts = texts_of(figure)
    check_inside(figure, texts)
    check_apart(texts)
    assert all(axes.get_xlabel() for axes in figure.axes if axes.get_ylabel() == "L*")


@pytest.mark.parametrize("name", NAMES)
def test_caption_names_the_data(made, name):
    own = made(name)
    assert own.caption.startswith(f"{own.recipe.title}.\n")
    if "issa" in str(own.recipe.files):
        assert "CC BY 4.0" in own.caption
    assert own.recipe.files
    for table in own.tables.values():
        assert len(table)


def test_1a_holds_one_persons_sites_and_everyones_mean(made):
    table = made("1a").tables[""]
    own = average_repeats(load_archive("issa"))
    hands = select(own, site="back of hand")
    part = table[table["site"] == "back of hand"].set_index("wavelength_nm")
    assert part["people"].iloc[0] == hands.sizes["record"]
    column = hands["reflectance"].sel(wavelength=550).values
    assert_allclose(part.loc[550, "mean"], np.nanmean(column))
    assert_allclose(part.loc[550, "standard_deviation"], np.nanstd(column, ddof=1))
    assert tuple(table["site"].unique()[:4]) == SITES


def test_1b_is_brightest_at_normal_incidence(made):
    table = made("1b").tables[""]
    by_angle = table.groupby("illumination_deg")["specular"]
    assert (by_angle.max() == by_angle.min()).all()  # a mirror has no colour
    specular = by_angle.first()
    assert specular.is_monotonic_decreasing
    # Fresnel at n = 1.4 and 0°, times the lobe's weight.
    from skinviz import TorranceSparrow

    expected = ((1.4 - 1) / (1.4 + 1)) ** 2 * TorranceSparrow().beta
    assert_allclose(specular.loc[0], expected, rtol=1e-9)
    assert_allclose(table["radiance_factor"], table["diffuse"] + table["specular"])


def test_5_and_6_hold_the_shipped_coefficients(made):
    for name, column, attribute in (
        ("5", "K_m_mm1", "melanin"),
        ("6", "S_d_mm1", "dermis"),
    ):
        table = made(name).tables[""]
        own = table[table["coefficients"] == "textbook"]
        shipped = load_coefficients("textbook").at(own["wavelength_nm"])
        assert_allclose(own[column], getattr(shipped, attribute))


def test_7_fits_what_was_measured(made):
    spectra, fits = made("7").tables[""], made("7").tables["fits"]
    for site in SITES:
        own = spectra[spectra["site"] == site]
        model = skin_model("cotton", site=site, specular="included")
        fit = fit_skin(own["measured"], own["wavelength_nm"], model)
        assert_allclose(own["cotton"], fit.fitted, atol=1e-6)
        row = fits[(fits["site"] == site) & (fits["curve"] == "cotton")].iloc[0]
        squares = ((own["cotton"] - own["measured"]) ** 2).sum()
        assert row["sse_61"] == pytest.approx(squares * 61 / len(own))


def test_9_shines_only_where_light_and_view_are_opposite(made):
    table = made("9").tables[""].set_index("picture")
    chroma = np.hypot(table["a"], table["b"])
    shiny = chroma.filter(like="60/60").iloc[0]
    assert shiny < 0.7 * chroma.drop(chroma.filter(like="60/60").index).min()


def test_10_darkens_with_melanin_and_reddens_with_oxyhaemoglobin(made):
    table = made("10").tables[""]
    L, a = (table[key].to_numpy().reshape(4, 4) for key in "La")
    assert (np.diff(L, axis=0) < 0).all()
    assert (np.diff(a, axis=1) > 0).all()
    # Under much melanin blood shows less, as the paper says.
    assert a[3, 3] - a[3, 0] < 0.6 * (a[0, 3] - a[0, 0])


def test_hands_share_scale_and_size(made):
    for name in HANDS:
        own = made(name)
        assert own.tables[""]["pixel_mm"].nunique() == 1
        assert len({p.shape for p in own.material.pictures.values()}) == 1
        assert (own.tables[""]["over_exposed"] == 0).all()


def test_metameric_lights_have_one_white():
    nm = np.arange(380.0, 781)
    white = spectrum_to_xyz(np.ones(nm.size), nm, "D65")
    for triple in TRIPLES:
        lamp = white_lines(triple)
        assert (lamp.lines[:, 1] > 0).all()
        assert_allclose(spectrum_to_xyz(np.ones(nm.size), nm, lamp), white, rtol=1e-9)


def test_metamerism_pairs_match_in_daylight_alone(made):
    pairs = made("metamerism").tables["pairs"]
    for _, own in pairs.groupby(["pair", "light"]):
        lab = own[list("Lab")].to_numpy()
        apart = delta_e_2000(lab[0], lab[1])
        assert own["delta_e_00"].tolist() == pytest.approx([float(apart)] * 2)
    daylight = pairs["light"] == "D65"
    assert pairs[daylight]["delta_e_00"].max() <= 0.5
    assert pairs[~daylight].groupby("pair")["delta_e_00"].max().min() > 1
    assert pairs["skin"].nunique() == 2 * pairs["pair"].nunique()


def test_population_leaves_duplicates_out_and_nobody_twice(made):
    table = made("population").tables[""]
    assert not table.duplicated(["person", "site"]).any()
    archive = load_archive("issa")
    clear = archive.isel(record=np.flatnonzero(~archive["duplicate"].values))
    cheeks = select(clear, site="cheek")
    labels = zip(cheeks["origin"].values, cheeks["subject"].values, strict=True)
    shown = set(table[table["site"] == "cheek"]["person"])
    assert shown == {f"{origin}/{subject}" for origin, subject in labels}


def test_uncertainty_is_of_the_seed_only_where_it_draws_lots(made):
    own = made("uncertainty")
    other = own.recipe.data(dataclasses.replace(own.settings, seed=7))
    by_lot = own.tables[""]["quantity"] == "colour"
    first, second = (
        table[["q05", "median", "q95"]] for table in (own.tables[""], other.tables[""])
    )
    assert_allclose(first[~by_lot], second[~by_lot])
    assert_allclose(first[by_lot], second[by_lot], rtol=0.05)
    assert not np.array_equal(first[by_lot], second[by_lot])


def test_transport_averages_the_shipped_comparison(made):
    table = made("transport").tables[""]
    row = table[
        (table["case"] == "body")
        & (table["rule"] == "gate")
        & (table["melanin"] == 0.01)
    ].iloc[0]
    assert row["skins"] == 4 * 13
    assert 0.2 < row["mean_dE00"] < 0.4
    assert set(table["rule"]) == {"gate", "star", "klier", "meador_weaver", "toon"}
