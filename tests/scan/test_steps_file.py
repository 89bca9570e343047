"""Steps in a TOML file: their order, units and faults."""

import numpy as np
import pytest

from skinviz.errors import MeshError
from skinviz.scan.clean import STEPS, Step
from skinviz.scan.steps import KINDS
from skinviz.scan.steps_file import read_steps


def written(tmp_path, text):
    file = tmp_path / "steps.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_steps_come_in_the_order_of_the_file_and_may_repeat(tmp_path):
    names = ("repair", "remesh", "drop islands", "remesh", "check")
    text = "\n".join(f"[[step]]\nname = '{name}'" for name in names)
    assert read_steps(written(tmp_path, text)) == tuple(map(Step, names))


def test_lengths_are_in_mm_and_angles_in_degrees(tmp_path):
    text = (
        "[[step]]\nname = 'triangulate'\nmax_incidence = 60\nmin_island = 50\n"
        "[[step]]\nname = 'merge'\ncell = 0.8\n"
        "[[step]]\nname = 'close holes'\ncap_wrist = true\n"
    )
    first, second, third = read_steps(written(tmp_path, text))
    assert first.parameters == {"max_incidence": np.deg2rad(60), "min_island": 50}
    assert second.parameters == {"cell": 0.8}
    assert third.parameters == {"cap_wrist": True}


def test_every_parameter_of_every_step_can_be_said(tmp_path):
    lines = []
    for name in STEPS:
        lines += ["[[step]]", f"name = '{name}'"]
        for key, known in KINDS[name].parameters.items():
            turn = 180 / np.pi if known.unit == "rad" else 1
            lines.append(f"{key} = {float(known.default * turn)}")
    for step in read_steps(written(tmp_path, "\n".join(lines))):
        default = {k: p.default for k, p in KINDS[step.name].parameters.items()}
        assert step.parameters == pytest.approx(default)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[[step", "is not TOML"),
        ("", "empty"),
        ("# nothing\n", r"expected a table \[\[step\]\]"),
        ("[step]\nname = 'repair'", r"expected a table \[\[step\]\]"),
        ("[[step]]\nname='repair'\n[steps]\nx = 1", "nothing else; got steps"),
        ("[[step]]\nedge_length = 1.0", "step 1 has no name"),
        ("[[step]]\nname = 3", "step 1 has no name"),
        ("step = [1]", "step 1 has no name"),
        (
            "[[step]]\nname='repair'\n[[step]]\nname='polish'",
            "step 2: there is no step",
        ),
        ("[[step]]\nname='repair'\nedge_length = 1.0", "'repair' has no parameter"),
        ("[[step]]\nname='remesh'\nedge_length = 100", r"step 1: edge_length .* mm"),
        ("[[step]]\nname='remesh'\nedge_length = nan", "step 1: edge_length"),
        ("[[step]]\nname='remesh'\nedge_length = [1]", "step 1: edge_length"),
        ("[[step]]\nname='triangulate'\nmax_incidence = '75'", "angle in degrees"),
        ("[[step]]\nname='triangulate'\nmax_incidence = 1.0e4", "max_incidence"),
    ],
)
def test_a_faulty_file_is_refused_with_what_is_wrong(tmp_path, text, told):
    with pytest.raises(MeshError, match=told) as caught:
        read_steps(written(tmp_path, text))
    assert "steps.toml" in str(caught.value)


def test_a_file_that_is_not_text_is_refused(tmp_path):
    (tmp_path / "steps.toml").write_bytes(b"\xff\xfe[[step]]")
    with pytest.raises(MeshError, match="is not TOML"):
        read_steps(tmp_path / "steps.toml")
