"""The gallery in the docs: of this version, with pictures that are not too large."""

import re
import runpy
from pathlib import Path

import pytest
from PIL import Image

from skinviz.view.gallery.catalogue import NAMES, recipe_of

ROOT = Path(__file__).parents[3]
AGAIN = "run ``python scripts/figures_page.py``"


@pytest.fixture(scope="module")
def script():
    return runpy.run_path(str(ROOT / "scripts" / "figures_page.py"))


def test_the_page_has_every_figure_with_its_command():
    text = (ROOT / "docs" / "figures.md").read_text("utf-8")
    assert [recipe_of(name).title for name in NAMES] == re.findall(
        "^## (.*)", text, re.M
    )
    for name in NAMES:
        assert f"skinviz figure {name} --out figures\n" in text
    for picture in re.findall(r"\((images/.*?)\)", text):
        file = ROOT / "docs" / picture
        assert file.stat().st_size < 150_000
        with Image.open(file) as image:
            assert image.width > 200


@pytest.mark.parametrize("name", ["1a", "6", "table-2", "metamerism"])
def test_captions_in_the_docs_are_of_this_version(made, script, name):
    text = (ROOT / "docs" / "figures.md").read_text("utf-8")
    assert script["section"](made(name)) in text, AGAIN


def test_the_script_writes_pictures(made, script, tmp_path):
    script["picture"](made("6"), tmp_path)
    with Image.open(tmp_path / "fig_6.png") as image:
        assert image.width == pytest.approx(183 / 25.4 * script["DOTS"], abs=1)
