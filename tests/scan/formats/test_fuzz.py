"""Broken files of every kind: read as something valid, or refused by name."""

import time
import zlib

import numpy as np
import pytest
from scan_files import (
    KINDS,
    MUTATIONS,
    STATES_UNIT,
    check_scan,
    mutated,
    write_sample,
)

from skinviz.errors import MeshError
from skinviz.scan.formats import read_scan
from skinviz.scan.formats.read import _READERS

N_MUTATIONS = 25
"""Of each kind; ``scripts/benchmarks/fuzz_readers.py`` makes thousands."""


def refusal(path, kind):
    """The error that a file meets; empty if it is read as something valid."""
    try:
        check_scan(read_scan(path, None if kind in STATES_UNIT else "mm"))
    except MeshError as error:
        return str(error)
    return ""


def test_every_suffix_has_a_sample():
    assert {suffix for suffix, _ in KINDS.values()} == set(_READERS)


@pytest.mark.parametrize("kind", KINDS)
def test_the_sample_itself_is_read(tmp_path, kind):
    path = write_sample(kind, tmp_path)
    check_scan(read_scan(path, None if kind in STATES_UNIT else "mm"))


@pytest.mark.parametrize("kind", KINDS)
def test_a_mutated_file_is_read_whole_or_refused_by_name(tmp_path, kind):
    path = write_sample(kind, tmp_path)
    content = path.read_bytes()
    rng = np.random.default_rng(zlib.crc32(kind.encode()))
    outcomes = {"read": 0, "refused": 0}
    for _ in range(N_MUTATIONS):
        path.write_bytes(mutated(content, rng))
        began = time.perf_counter()
        told = refusal(path, kind)
        assert time.perf_counter() - began < 10
        outcomes["refused" if told else "read"] += 1
        if told:
            assert path.stem in told
            assert len(told) < 600
    assert outcomes["refused"] >= N_MUTATIONS // 5


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda f: f.__name__)
def test_a_mutation_changes_bytes_and_is_reproducible(mutation):
    content = b"ply 12 3.5\n4 5\n" * 30
    results = [mutation(content, np.random.default_rng(k)) for k in (0, 0, 1, 2, 3)]
    assert results[0] == results[1]
    assert any(result != content for result in results)


def test_numbers_that_overflow_are_refused_without_a_warning(tmp_path):
    path = tmp_path / "a.xyz"  # pytest makes an error of every warning
    path.write_text("1e308 1e308 1e308\n")
    with pytest.raises(MeshError, match=r"a\.xyz"):
        read_scan(path, "m")
