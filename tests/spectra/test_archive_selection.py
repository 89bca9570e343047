"""Choosing, averaging and naming an archive's spectra; counts of its faults."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from skinviz import ArgumentError, load_archive, read_spectra, write_spectra
from skinviz.spectra.archive_data import LABELS, archive_dataset
from skinviz.spectra.archive_selection import (
    average_repeats,
    common_bands,
    people,
    select,
    with_labels,
)
from skinviz.spectra.archive_summary import summary

FOUR_SITES = ("cheek", "back of hand", "outer arm", "inner arm")


@pytest.fixture(scope="module")
def issa():
    return load_archive("issa")


def small(rows, spectra):
    """Return an archive of (subject, sex, site) rows; origin and the rest alike."""
    subject, sex, site = (np.array(c, dtype=object) for c in zip(*rows, strict=True))
    same = {"origin": "X", "group": "G", "age_group": ""}
    labels = {
        **{key: np.full(len(rows), value, object) for key, value in same.items()},
        "subject": subject,
        "sex": sex,
        "site": site,
    }
    spectra = np.asarray(spectra, dtype=float)
    nm = 400.0 + 10 * np.arange(spectra.shape[1])
    attributes = {"source": "s", "licence": "l", "specular": "included"}
    return archive_dataset(np.arange(1, len(rows) + 1), labels, nm, spectra, attributes)


def test_the_faults_of_issa_number_as_documented(issa):
    counts = summary(issa)
    assert counts["duplicates"] == 114
    assert counts["two_sexes"] == ["Iraq/493", "Iraq/494"]
    assert counts["repeats"] == {"spectra": 1424, "subject_sites": 711}
    four = select(issa, site=FOUR_SITES)
    assert summary(four)["repeats"] == {"spectra": 838, "subject_sites": 418}
    own = four.isel(record=~four.duplicate.values)
    assert (np.unique(places(own), return_counts=True)[1] > 1).sum() == 414


def places(archive):
    return people(archive) + "/" + archive.site.values.astype(str)


def test_most_repeats_are_cheeks_and_necks_of_two_datasets(issa):
    # The publisher measured both sides there and did not record which is which.
    repeated = issa.isel(record=issa.repeats.values > 0)
    own = select(repeated, origin=["UK2", "UK3"])
    assert set(own.site.values) == {"cheek", "neck"}
    assert own.sizes["record"] > 0.9 * repeated.sizes["record"]


def test_origin_is_confounded_with_group(issa):
    pairs = set(zip(issa.origin.values, issa.group.values, strict=True))
    groups_of = [
        sum(o == origin for o, _ in pairs) for origin in set(issa.origin.values)
    ]
    assert sorted(groups_of) == [1, 1, 1, 1, 1, 1, 3]


def test_summary_adds_up(issa):
    counts = summary(issa)
    for label in ("origin", "sex", "age_group", "group"):
        assert sum(n["spectra"] for n in counts[label].values()) == 8307
    assert (
        sum(n["people"] for n in counts["origin"].values()) == counts["people"] == 1058
    )
    table = counts["table"]
    assert len(table) == counts["sites"] == 12
    assert sum(n["spectra"] for row in table.values() for n in row.values()) == 8307
    assert table["ring finger"] == {
        "African": {"spectra": 9, "people": 9},
        "South Asian": {"spectra": 116, "people": 116},
    }
    assert counts["wavelengths"] == [
        {"from": 360.0, "to": 740.0, "spectra": 4485},
        {"from": 400.0, "to": 700.0, "spectra": 3822},
    ]


def test_select_keeps_what_has_all_labels(issa):
    chosen = select(issa, site=["palm", "cheek"], origin="China", sex="F")
    assert set(chosen.site.values) == {"palm", "cheek"}
    assert set(chosen.origin.values) == {"China"}
    assert set(chosen.sex.values) == {"F"}
    kept = np.isin(issa.record, chosen.record)
    mask = np.isin(issa.site, ["palm", "cheek"]) & (issa.origin.values == "China")
    assert_array_equal(kept, mask & (issa.sex.values == "F"))
    assert select(issa).equals(issa)
    assert select(issa, subject="186", site="palm").record.size == 1
    assert select(issa, age_group="").record.size == 2716


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"site": "hand"}, "unknown site 'hand'; choose one of: back of hand, cheek"),
        ({"sex": "female"}, "unknown sex 'female'; choose one of: F, M"),
        ({"age_group": "20"}, "unknown age group '20'; choose one of: 20-29"),
        ({"subject": "0"}, r"unknown subject '0'; there is 1, 2, 3 ... 1772 \(1058"),
        (
            {"site": "palm", "group": "South Asian"},
            "no spectrum of site palm has group South Asian; with site palm there is "
            "group African, Caucasian, Chinese, Middle Eastern",
        ),
        (
            {"site": "palm", "subject": "1400"},
            r"with site palm there is subject 1, 2, 3 ... \d+ \(552 of them\)",
        ),
    ],
)
def test_select_names_what_there_is(issa, asked, told):
    with pytest.raises(ArgumentError, match=told) as caught:
        select(issa, **asked)
    assert "np." not in str(caught.value)


def test_averaging_gives_one_spectrum_per_person_and_site(issa):
    averaged = average_repeats(issa)
    own = issa.isel(record=~issa.duplicate.values)
    assert averaged.sizes["record"] == np.unique(places(own)).size == 7488
    assert np.unique(places(averaged)).size == 7488
    assert averaged.n_spectra.values.sum() == own.sizes["record"] == 8193
    assert not averaged.duplicate.any()
    assert not averaged.repeats.any()
    assert averaged.attrs == issa.attrs
    assert set(issa.coords) < set(averaged.coords)


def test_averages_are_means_by_another_way(issa):
    own = issa.isel(record=~issa.duplicate.values)
    frame = own.reflectance.to_pandas().groupby(places(own)).mean()
    averaged = average_repeats(issa)
    expected = frame.loc[places(averaged)].to_numpy()
    assert_allclose(averaged.reflectance, expected, rtol=1e-14)


def test_averaging_uses_the_bands_each_record_has():
    nan = np.nan
    rows = [("1", "F", "palm"), ("2", "M", "palm"), ("1", "F", "palm")]
    found = average_repeats(small(rows, [[nan, 0.2, nan], [0.5] * 3, [0.1, 0.4, nan]]))
    assert_allclose(found.reflectance, [[0.1, 0.3, nan], [0.5, 0.5, 0.5]], rtol=1e-15)
    assert found.n_spectra.values.tolist() == [2, 1]
    assert found.record.values.tolist() == [1, 2]


def test_a_label_on_which_repeats_differ_is_not_chosen_between():
    rows = [
        ("1", "F", "palm"),
        ("1", "M", "palm"),
        ("1", "F", "chin"),
        ("2", "", "chin"),
    ]
    archive = small(rows, np.arange(1, 13).reshape(4, 3) / 20)
    assert archive.two_sexes.values.tolist() == [True, True, True, False]
    averaged = average_repeats(archive)
    assert averaged.sex.values.tolist() == ["", "F", ""]
    assert averaged.two_sexes.values.tolist() == [True, True, False]


def test_a_person_without_a_recorded_sex_has_not_two():
    rows = [("1", "F", "palm"), ("1", "", "chin")]
    assert not small(rows, [[0.1, 0.2], [0.2, 0.3]]).two_sexes.any()


def test_only_duplicates_cannot_be_averaged():
    rows = [("1", "F", "palm"), ("2", "F", "palm")]
    archive = small(rows, [[0.1, 0.2], [0.1, 0.2]])
    assert archive.duplicate.all()
    with pytest.raises(ArgumentError, match="but duplicates"):
        average_repeats(archive)


def test_labels_name_person_and_site_once(issa):
    labelled = with_labels(issa)
    names = labelled.label.values
    assert np.unique(names.astype(str)).size == 8307
    chosen = select(labelled, subject="186", site="back of hand")
    assert chosen.label.values.tolist() == ["China/186 back of hand"]
    cheeks = select(labelled, subject="1400", site="cheek").label.values
    assert cheeks.tolist() == ["UK2/1400 cheek", "UK2/1400 cheek 2"]


def test_chosen_spectra_can_be_written_and_read_back(issa, tmp_path):
    chosen = with_labels(common_bands(select(issa, site="palm")))
    assert_array_equal(chosen.wavelength, np.arange(400, 701, 10))
    back = read_spectra(write_spectra(tmp_path / "palm.csv", chosen))
    assert_array_equal(back.reflectance, chosen.reflectance)
    assert_array_equal(back.label, chosen.label)
    assert back.attrs["specular"] == "included"


def test_spectra_without_a_common_band_are_said():
    rows = [("1", "F", "palm"), ("2", "F", "palm")]
    archive = small(rows, [[0.1, np.nan], [np.nan, 0.2]])
    with pytest.raises(ArgumentError, match="no band that all"):
        common_bands(archive)


def test_every_label_can_be_selected_by(issa):
    for label in LABELS:
        value = issa[label].values[100]
        assert set(select(issa, **{label: value})[label].values) == {value}
