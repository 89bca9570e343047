"""Comparing levels: known weights come back, every design is tested as it must be."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats
from study_folders import BANDS, skin

from skinviz import ArgumentError, archive_study, compare_study, read_study
from skinviz.spectra.colorimetry import delta_e_2000, spectrum_to_xyz, xyz_to_lab
from skinviz.study.comparing import MOST_LEVELS
from skinviz.study.record_list import Entry
from skinviz.study.records import Record, as_dataset
from skinviz.study.study import Study

LAYERS = {"cheek": (0.027, 1.491), "inner arm": (0.041, 1.294)}
WEIGHTS = np.array([0.1, 0.006, 0.003])


def study_of(rows, title="made up"):
    """Return a study of (entry, weights) or (entry, spectrum) rows."""
    records = [
        Record(entry, BANDS, skin(own, entry.site) if len(own) == 3 else own)
        for entry, own in rows
    ]
    said = {"source": "", "licence": "", "geometry": "", "specular": "included"}
    return Study(title, as_dataset(records, said), LAYERS)


def before_and_after(n, factor, rng, *, noise=0.05):
    """Return a study in which oxyhaemoglobin grows by a factor within each person."""
    rows = []
    for i in range(n):
        own = WEIGHTS * np.exp(rng.normal(0, 0.2, 3))
        for condition, times in (("before", 1.0), ("after", factor)):
            for repeat in (1, 2):
                entry = Entry("f", "", f"P{i}", "cheek", condition, repeat)
                weights = own * [1, times, 1] * np.exp(rng.normal(0, noise, 3))
                rows.append((entry, weights))
    return study_of(rows)


def contrast(found, quantity, **where):
    """Return the only contrast of a quantity with these labels."""
    (own,) = [
        c
        for c in found.contrasts
        if c.quantity.name == quantity
        and all(getattr(c, key) == value for key, value in where.items())
    ]
    return own


def test_repeats_count_once_and_pairs_are_subjects():
    study = before_and_after(6, 1.4, np.random.default_rng(1))
    found = compare_study(study, "condition")
    assert found.levels == ("before", "after")
    (stratum,) = found.strata
    assert str(stratum) == "cheek"
    before, after = found.row(stratum)
    assert before.units == tuple(f"P{i}" for i in range(6))
    own = contrast(found, "w_h").difference
    k = [q.name for q in found.quantities].index("w_h")
    expected = stats.ttest_rel(after.values[:, k], before.values[:, k])
    assert_allclose(own.p, expected.pvalue, rtol=1e-9)
    assert own.n == (6, 6)
    assert before.means[k].mean == pytest.approx(before.values[:, k].mean())


def test_weights_that_were_put_in_come_back():
    rng = np.random.default_rng(2)
    rows, truth = [], []
    for i in range(4):
        own = WEIGHTS * np.exp(rng.normal(0, 0.3, 3))
        rows += [(Entry("f", "", f"P{i}", site), own) for site in LAYERS]
        truth.append(own)
    found = compare_study(study_of(rows), "site")
    for cell in found.cells:
        assert_allclose(cell.values[:, :3], truth, rtol=1e-6)
    depth = contrast(found, "w_m_depth").difference
    expected = np.mean(truth, axis=0)[0] * (0.041 - 0.027)
    assert_allclose(depth.difference, expected, rtol=1e-6)


def test_a_melanin_depth_is_compared_between_sites_only():
    study = before_and_after(3, 1.2, np.random.default_rng(1))
    names = [q.name for q in compare_study(study, "condition").quantities]
    assert "w_m_depth" not in names


def test_true_differences_lie_in_intervals_at_their_rate():
    rng = np.random.default_rng(4)
    middle = WEIGHTS[1] * np.exp((0.2**2 + 0.05**2) / 2)
    hits, n = 0, 100
    for _ in range(n):
        found = compare_study(before_and_after(8, 1.3, rng), "condition")
        own = contrast(found, "w_h").difference
        hits += own.low <= 0.3 * middle <= own.high
    assert abs(hits / n - 0.95) < 3.5 * np.sqrt(0.95 * 0.05 / n)


def test_other_people_at_each_level_are_compared_unpaired():
    rng = np.random.default_rng(5)
    rows = [
        (
            Entry("f", "", f"{group}{i}", "cheek", group=group),
            WEIGHTS * times * np.exp(rng.normal(0, 0.1, 3)),
        )
        for group, times, n in (("x", 1.0, 5), ("y", 1.5, 7))
        for i in range(n)
    ]
    found = compare_study(study_of(rows), "group")
    own = contrast(found, "w_m").difference
    first, second = (cell.values[:, 0] for cell in found.cells)
    expected = stats.ttest_ind(second, first, equal_var=False)
    assert_allclose(own.p, expected.pvalue, rtol=1e-9)
    assert (own.test, own.n) == ("Welch t", (5, 7))


def test_a_design_with_few_pairs_is_compared_without_them():
    conditions = {"before": range(6), "after": range(5, 12)}
    rng = np.random.default_rng(6)
    rows = [
        (
            Entry("f", "", f"P{i}", "cheek", condition),
            WEIGHTS * np.exp(rng.normal(0, 0.1, 3)),
        )
        for condition, who in conditions.items()
        for i in who
    ]
    own = contrast(compare_study(study_of(rows), "condition"), "w_m").difference
    assert (own.test, own.n) == ("Welch t", (5, 6))


def test_origin_is_a_factor_where_people_come_from_several():
    rng = np.random.default_rng(7)
    rows = []
    for group, origin, n in (
        *(("x", "Lab1", 9), ("x", "Lab2", 3), ("y", "Lab1", 3), ("y", "Lab2", 9)),
        ("z", "Lab3", 4),
    ):
        for i in range(n):
            # All that differs is the laboratory, with twice the pigment.
            times = 2.0 if origin == "Lab2" else 1.0
            entry = Entry(
                *("f", "", f"{group}{origin}{i}", "cheek"), group=group, origin=origin
            )
            rows.append((entry, WEIGHTS * times * np.exp(rng.normal(0, 0.05, 3))))
    found = compare_study(study_of(rows), "group")
    own = contrast(found, "w_m", first="x", second="y").difference
    assert own.test == "t within origins"
    assert own.low < 0 < own.high
    alone = stats.ttest_ind(*(cell.values[:, 0] for cell in found.cells[:2]))
    assert alone.pvalue < 0.02  # what would be claimed without the factor
    other = contrast(found, "w_m", first="x", second="z")
    assert other.difference.why == "confounded with origin"
    assert other.p_holm is None


def test_one_subject_has_means_and_no_test():
    rows = [
        (Entry("f", "", "P", "cheek", condition), WEIGHTS * times)
        for condition, times in (("before", 1.0), ("after", 1.2))
    ]
    found = compare_study(study_of(rows), "condition")
    for own in found.contrasts:
        assert own.difference.why == "too few"
        assert own.difference.difference is not None
        assert own.p_holm is None
    assert all(
        np.isfinite([c.delta_e, c.fitted, c.low, c.high]).all() for c in found.colours
    )


def test_people_who_are_alike_have_no_variance():
    rows = [
        (Entry("f", "", f"P{i}", "cheek", condition), WEIGHTS * times)
        for i in range(4)
        for condition, times in (("before", 1.0), ("after", 1.2))
    ]
    spectra = study_of(rows)
    found = compare_study(spectra, "condition")
    assert {c.difference.why for c in found.contrasts} == {"no variance"}


def test_subjects_are_compared_over_their_repeats():
    rng = np.random.default_rng(9)
    rows = [
        (
            Entry("f", "", subject, "cheek", "", repeat),
            WEIGHTS * times * np.exp(rng.normal(0, 0.02, 3)),
        )
        for subject, times in (("A", 1.0), ("B", 1.3), ("C", 1.6))
        for repeat in (1, 2, 3)
    ]
    found = compare_study(study_of(rows), "subject")
    assert found.unit == "repeat"
    assert found.cells[0].units == ("repeat 1", "repeat 2", "repeat 3")
    own = contrast(found, "w_m", first="A", second="C").difference
    assert (own.test, own.n) == ("Welch t", (3, 3))
    assert own.low < 0.06 < own.high
    chosen = compare_study(study_of(rows), "subject", levels=["C", "A"])
    assert chosen.levels == ("A", "C")


def test_of_many_levels_no_pairs_are_made():
    rows = [
        (Entry("f", "", f"P{i}", "cheek", "", repeat), WEIGHTS * (1 + i / 50))
        for i in range(MOST_LEVELS + 1)
        for repeat in (1, 2)
    ]
    found = compare_study(study_of(rows), "subject")
    assert len(found.cells) == MOST_LEVELS + 1
    assert found.contrasts == found.colours == ()


def test_spectra_that_cannot_be_fitted_are_gaps():
    study = before_and_after(3, 1.2, np.random.default_rng(1))
    values = study.spectra["reflectance"].values.copy()
    values[0, 3:] = np.nan  # three bands for three weights
    values[1, 5] = -0.1
    spectra = study.spectra.assign(reflectance=(("record", "wavelength"), values))
    found = compare_study(dataclasses.replace(study, spectra=spectra), "condition")
    assert [(g.subject, g.condition, g.repeat, g.why) for g in found.gaps] == [
        ("P0", "before", 1, "its fit failed"),
        ("P0", "before", 2, "its fit failed"),
    ]
    assert found.cells[0].units == ("P1", "P2")
    assert contrast(found, "w_h").difference.n == (2, 2)
    assert all(np.isfinite(cell.values).all() for cell in found.cells)


def test_missing_bands_do_not_reach_the_means():
    study = before_and_after(3, 1.2, np.random.default_rng(1))
    values = study.spectra["reflectance"].values.copy()
    whole = compare_study(study, "condition")
    values[0, 7] = np.nan
    spectra = study.spectra.assign(reflectance=(("record", "wavelength"), values))
    found = compare_study(dataclasses.replace(study, spectra=spectra), "condition")
    assert np.isfinite(found.cells[0].mean_spectrum).all()
    assert_allclose(found.cells[0].values, whole.cells[0].values, rtol=1e-5)


def test_the_colour_difference_is_that_of_the_mean_spectra():
    study = before_and_after(4, 1.5, np.random.default_rng(1))
    found = compare_study(study, "condition")
    (own,) = found.colours
    white = spectrum_to_xyz(np.ones(BANDS.size), BANDS)
    labs = [
        xyz_to_lab(spectrum_to_xyz(c.mean_spectrum, BANDS), white) for c in found.cells
    ]
    assert_allclose(own.delta_e, delta_e_2000(*labs), rtol=1e-9)
    assert own.low <= own.fitted <= own.high


def test_colours_of_sites_are_drawn_apart():
    rows = [(Entry("f", "", "P", site), WEIGHTS) for site in LAYERS]
    bent = [(entry, skin(own, entry.site) * (1 + 1e-4 * BANDS)) for entry, own in rows]
    first, second = compare_study(study_of(bent), "site").cells
    away = [(c.colour.samples - c.colour.lab)[:, 0] for c in (first, second)]
    assert abs(np.corrcoef(*away)[0, 1]) < 0.15


def test_the_same_seed_gives_the_same_numbers():
    study = read_study("docs/examples/study")
    one, two, three = (compare_study(study, "site", seed=s) for s in (1, 1, 2))
    assert one.contrasts == two.contrasts == three.contrasts
    assert one.colours == two.colours
    assert one.colours != three.colours


def test_p_values_are_corrected_over_the_whole_comparison():
    found = compare_study(read_study("docs/examples/study"), "condition")
    raw = np.array([c.difference.p for c in found.contrasts])
    corrected = np.array([c.p_holm for c in found.contrasts])
    assert_allclose(corrected.min(), raw.min() * raw.size, rtol=1e-12)
    assert (corrected >= raw).all()


@pytest.mark.parametrize(
    ("by", "levels", "told"),
    [
        ("place", (), "unknown factor to compare by 'place'"),
        ("site", ("nose",), "unknown site 'nose'"),
        ("site", ("cheek",), "needs at least two of them; there is 'cheek' alone"),
        ("group", (), "needs at least two of them; there is none told"),
    ],
)
def test_what_cannot_be_compared_is_refused(folder, by, levels, told):
    with pytest.raises(ArgumentError, match=told):
        compare_study(read_study(folder), by, levels=levels)


def test_records_without_a_level_are_gaps():
    rows = [
        (Entry("f", "", f"{group}{i}", "cheek", group=group), WEIGHTS * (1 + i / 10))
        for group in ("x", "y", "")
        for i in range(3)
    ]
    found = compare_study(study_of(rows), "group")
    assert [g.why for g in found.gaps] == ["its group is not told"] * 3
    assert found.levels == ("x", "y")


@pytest.mark.parametrize("model", ["cotton", "lambert-beer", "extended"])
def test_every_model_can_be_compared(model):
    study = before_and_after(3, 1.3, np.random.default_rng(1))
    found = compare_study(study, "condition", model=model)
    assert found.quantities[0].name == "w_m"
    assert contrast(found, "w_h").difference.difference > 0


def test_an_archive_opens_as_a_study():
    study = archive_study("issa", group=["Chinese", "Caucasian"], site="cheek")
    assert study.levels("group") == ("Caucasian", "Chinese")
    assert study.levels("condition") == ("",)
    duplicates = {g.subject for g in study.gaps if "another subject" in g.why}
    assert {"China/189", "China/190", "China/195", "China/196"} <= duplicates
    assert not duplicates & set(study.levels("subject"))
    found = compare_study(study, "group")
    own = contrast(found, "w_m").difference
    assert (own.test, own.n) == ("t within origins", (155, 53))


def test_sites_of_an_archive_can_be_said_to_be_like_others():
    plain = archive_study("issa", group="Chinese")
    assert set(plain.levels("site")) == {
        "cheek",
        "back of hand",
        "outer arm",
        "inner arm",
    }
    unknown = {g.site for g in plain.gaps if "thickness" in g.why}
    assert "palm" in unknown
    told = archive_study(
        "issa",
        group="Chinese",
        site=["palm", "cheek"],
        sites={"palm": {"like": "cheek"}},
    )
    assert set(told.levels("site")) == {"palm", "cheek"}
    assert_array_equal(told.layers["palm"], told.layers["cheek"])


def test_several_spectra_of_an_archives_site_are_repeats():
    study = archive_study("issa", origin="UK", site="cheek")
    repeats = study.spectra["repeat"].values
    assert repeats.max() > 1
    subjects = study.spectra["subject"].values
    own = subjects == subjects[repeats.argmax()]
    assert_array_equal(repeats[own], np.arange(1, own.sum() + 1))
    assert own.sum() == repeats.max()
