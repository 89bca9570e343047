"""Figures by name: what is asked, what is written, what is refused."""

import io
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image

import skinviz
from skinviz.errors import ArgumentError, SkinvizError
from skinviz.view.gallery import catalogue
from skinviz.view.gallery.catalogue import MODULES, NAMES, figure, recipe_of
from skinviz.view.gallery.text import as_csv, as_markdown, as_text

ROOT = Path(__file__).parents[3]


def test_every_name_has_a_recipe_and_a_script():
    stems = [recipe_of(name).stem for name in NAMES]
    assert len(set(stems)) == len(NAMES)
    for name, module in MODULES.items():
        assert recipe_of(name).name == name
        script = (ROOT / "scripts" / "figures" / f"{module}.py").read_text("utf-8")
        assert f'figure("{name}")' in script
        assert len(script.splitlines()) <= 6


def test_a_plot_is_written_in_all_formats(made, tmp_path):
    files = made("1b").save(tmp_path)
    assert sorted(f.name for f in tmp_path.iterdir()) == sorted(f.name for f in files)
    assert [f.suffix for f in files] == [".png", ".svg", ".pdf", ".csv", ".txt"]
    assert {f.stem for f in files} == {"fig_1b"}
    with Image.open(files[0]) as picture:
        assert picture.width == pytest.approx(89 / 25.4 * 30, abs=1)
    assert (tmp_path / "fig_1b.txt").read_text("utf-8") == made("1b").caption
    table = pd.read_csv(tmp_path / "fig_1b.csv")
    np.testing.assert_allclose(
        table["radiance_factor"], made("1b").tables[""]["radiance_factor"], rtol=1e-5
    )


def test_hands_are_pictures_and_tables_have_none(made, tmp_path):
    assert {f.suffix for f in made("8").save(tmp_path)} == {".png", ".csv", ".txt"}
    names = {f.name for f in made("table-2").save(tmp_path)}
    assert names == {
        "table_2.csv",
        "table_2_orders.csv",
        "table_2_claims.csv",
        "table_2.txt",
    }
    assert made("table-2").draw() is None


def test_the_same_again_is_the_same_to_the_byte(made, tmp_path):
    for name in ("1b", "uncertainty"):
        first = made(name).save(tmp_path / "a")
        again = figure(name, width=25.4 * recipe_of(name).width, dots=30)
        for one, other in zip(first, again.save(tmp_path / "b"), strict=True):
            assert one.read_bytes() == other.read_bytes(), one.name


def test_numbers_are_names_too():
    assert recipe_of(7) is recipe_of("7")


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"name": "fig-7"}, "unknown figure 'fig-7'; choose one of: 1a"),
        ({"name": "popluation"}, "did you mean 'population'"),
        ({"name": "5", "width": 10}, "width of a figure must be in .* mm"),
        ({"name": "5", "width": np.nan}, "width of a figure"),
        ({"name": "5", "dots": 5}, "dots must be in"),
        ({"name": "5", "seed": -1}, "seed must be in"),
    ],
)
def test_what_cannot_be_is_refused(asked, told):
    with pytest.raises(ArgumentError, match=told):
        figure(**asked)


def test_nothing_is_left_where_not_all_can_be_written(made, tmp_path, monkeypatch):
    def fail(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("skinviz.view.figures.save_figure", fail)
    with pytest.raises(SkinvizError, match="No space left"):
        made("1b").save(tmp_path)
    assert not list(tmp_path.iterdir())


def test_the_public_name_is_the_catalogues():
    assert skinviz.figure is catalogue.figure


def test_tables_as_text():
    table = pd.DataFrame({"site": ["cheek", "arm"], "value": [0.123456789, np.nan]})
    back = pd.read_csv(io.StringIO(as_csv(table)))
    assert back["value"].iloc[0] == 0.123457
    assert as_text(table) == "site   value\ncheek  0.1235\narm\n"
    assert as_markdown(table).splitlines()[1:] == [
        "|---|---|",
        "| cheek | 0.123 |",
        "| arm |  |",
    ]
