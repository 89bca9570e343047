"""Rebuild the example study in docs/examples/study from the two-layer model.

``python scripts/make_example_study.py [OUT]``. Eight made-up people, A to H, at two
body sites before and after sun, two repeats each. After sun the back of the hand has
1.5 times the oxyhaemoglobin, 1.2 times under sunscreen; the inner arm was covered.
Nobody was measured: weights are drawn around middles like those of real skin, and
noise is added. H has no inner arm after sun, so that the example has a gap.
"""

import sys
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr

from skinviz import TorranceSparrow, skin_model, write_spectra
from skinviz.surface.lobe_curve import in_plane

OUT = Path(__file__).parents[1] / "docs" / "examples" / "study"
BANDS = np.arange(400.0, 701.0, 10.0)
SITES = {"back of hand": (0.055, 0.0068, 0.0032), "inner arm": (0.030, 0.0030, 0.0012)}
CONDITIONS = ("before", "after sun")
SUN = {"sunscreen": 1.2, "none": 1.5}  # times the oxyhaemoglobin, where it shines
SUBJECTS = "ABCDEFGH"
GROUPS = {"sunscreen": "ABCD", "none": "EFGH"}
BETWEEN, WITHIN, NOISE = 0.20, 0.03, 0.0015  # of weights, log; of a band

STUDY = """\
# An example of a study: made up, computed by scripts/make_example_study.py.
# Subjects are pseudonyms; never write the names of people.
title = "Eight hands before and after sun (computed, not measured)"
specular = "included"            # excluded, included or a number
geometry = "di:8"
source = "computed by the two-layer model of skinviz, nobody was measured"
licence = "BSD-3-Clause"

pattern = "spectra/{subject}.csv"               # a file for each subject,
labels = "{site} / {condition} / {repeat}"      # several spectra in it

[subjects.A]
group = "sunscreen"
sex = "F"
age = 31
mesh = "../../../meshes/makehuman_male_right.ply"   # A's own hand
unit = "m"
gonio = "gonio/A.csv"

"""


def weights_of(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return one person's weights at each site."""
    person = rng.normal(0, BETWEEN, 3)
    return {
        site: np.array(middle) * np.exp(person + rng.normal(0, BETWEEN / 2, 3))
        for site, middle in SITES.items()
    }


def group_of(subject: str) -> str:
    """Return the group that a person is in."""
    return next(name for name, who in GROUPS.items() if subject in who)


def spectra_of(subject: str, rng: np.random.Generator) -> xr.Dataset:
    """Return all spectra of one person."""
    weights = weights_of(rng)
    labels, spectra = [], []
    for site, condition, repeat in product(SITES, CONDITIONS, (1, 2)):
        lit = (site, condition) == ("back of hand", "after sun")
        sun = SUN[group_of(subject)] if lit else 1.0
        own = weights[site] * np.exp(rng.normal(0, WITHIN, 3)) * [1, sun, 1]
        model = skin_model(site=site, specular="included")
        noise = rng.normal(0, NOISE, BANDS.size)
        if (subject, site, condition) == ("H", "inner arm", "after sun"):
            continue
        labels.append(f"{site} / {condition} / {repeat}")
        spectra.append(np.round(model.measured(own, BANDS) + noise, 5))
    return xr.Dataset(
        {"reflectance": (("record", "wavelength"), np.array(spectra))},
        coords={"wavelength": BANDS, "label": ("record", np.array(labels))},
        attrs={"specular": "included", "geometry": "di:8"},
    )


def main(out: Path) -> None:
    """Write the study's folder."""
    rng = np.random.default_rng(2005)
    (out / "gonio").mkdir(parents=True, exist_ok=True)
    tables = [STUDY]
    for subject in SUBJECTS:
        write_spectra(out / "spectra" / f"{subject}.csv", spectra_of(subject, rng))
        if subject != "A":
            sex, age = "FM"[rng.integers(2)], rng.integers(20, 60)
            traits = f'group = "{group_of(subject)}"\nsex = "{sex}"\nage = {age}'
            tables.append(f"[subjects.{subject}]\n{traits}\n")
    (out / "study.toml").write_text("\n".join(tables), "utf-8")
    angles = np.arange(0, 86, 5)
    lobe = in_plane(TorranceSparrow.from_beta(1.4, 0.24), np.deg2rad(angles))
    read = lobe + rng.normal(0, 0.004, angles.size)
    rows = [
        f"{angle},60,{value:.4f}" for angle, value in zip(angles, read, strict=True)
    ]
    (out / "gonio" / "A.csv").write_text(
        "\n".join(["illumination_deg,viewing_deg,specular", *rows, ""]), "utf-8"
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else OUT)
