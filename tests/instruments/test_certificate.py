"""Certificates of white tiles."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

from skinviz.errors import DataError
from skinviz.instruments.certificate import Certificate, read_certificate


def _file(tmp_path, rows, header="wavelength_nm,factor,uncertainty"):
    path = tmp_path / "tile.csv"
    path.write_text("\n".join([header, *rows]) + "\n", "utf-8")
    return path


ROWS = [f"{nm},0.98,0.002" for nm in range(380, 781, 50)]


def test_a_certificate_is_read_interpolated_and_kept(tmp_path):
    rows = ["380,0.97,0.003", "580,0.98,0.002", "780,0.99,0.002"]
    found = read_certificate(_file(tmp_path, rows))
    factor, u = found.at(np.array([370.0, 480.0, 780.0, 790.0]))
    assert_allclose(factor, [np.nan, 0.975, 0.99, np.nan])
    assert_allclose(u, [np.nan, 0.0025, 0.002, np.nan])
    again = Certificate.from_json(json.loads(json.dumps(found.to_json())))
    assert again.sha256 == found.sha256
    assert_allclose(again.factor, found.factor)


@pytest.mark.parametrize(
    ("rows", "header", "told"),
    [
        (ROWS, "wavelength_nm,a,b", "factor and uncertainty"),
        ([r.replace("0.002", "0.2") for r in ROWS], None, "tenth"),
        ([r.replace("0.98", "0") for r in ROWS], None, "0.02"),
        (["900,0.98,0.002", "999,0.98,0.002"], None, "needed for 380-780 nm"),
    ],
)
def test_what_is_no_certificate_is_refused(tmp_path, rows, header, told):
    path = _file(tmp_path, rows, header or "wavelength_nm,factor,uncertainty")
    with pytest.raises(DataError, match=told):
        read_certificate(path)


@pytest.mark.parametrize(
    "change",
    [{"factor": None}, {"factor": ["a"]}, {"factor": [0.98]}, {"wavelengths": 3}],
)
def test_a_log_without_a_certificate_is_refused(tmp_path, change):
    kept = read_certificate(_file(tmp_path, ROWS)).to_json()
    with pytest.raises(DataError, match="certificate"):
        Certificate.from_json(kept | change)
