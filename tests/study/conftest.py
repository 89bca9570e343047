"""A study's folder."""

import numpy as np
import pytest
from study_folders import skin, write_table


@pytest.fixture
def folder(tmp_path):
    """Three people at two sites in two conditions, one file a record."""
    rng = np.random.default_rng(3)
    for subject in "ABC":
        for site in ("cheek", "inner arm"):
            for condition, oxy in (("before", 0.006), ("after", 0.009)):
                own = np.array([0.1, oxy, 0.003]) * rng.uniform(0.9, 1.1, 3)
                name = f"{subject}_{site.replace(' ', '-')}_{condition}.csv"
                write_table(tmp_path / "spectra" / name, skin(own, site), [name])
    (tmp_path / "study.toml").write_text(
        'title = "three"\nspecular = "included"\n'
        'pattern = "spectra/{subject}_{site}_{condition}.csv"\n',
        "utf-8",
    )
    return tmp_path
