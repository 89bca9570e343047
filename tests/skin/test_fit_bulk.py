"""The fit in bulk: memory, every kind of array, threads, and being stopped."""

import signal
import threading
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from skinviz import fit_skin, skin_model

NM = np.arange(400.0, 701.0, 5.0)
MODEL = skin_model(site="back of hand", specular="included")
SIGMA = 2e-3
MOST_MEMORY = 3  # times the input, the input itself among it


def noisy(n, seed=1):
    """Return measured spectra (n, 61) of unlike skins."""
    rng = np.random.default_rng(seed)
    weights = rng.uniform((0.0, 0.0, 0.0), (0.4, 0.03, 0.02), (n, 3))
    clean = MODEL.measured(weights, NM)
    return np.maximum(clean + rng.normal(0, SIGMA, clean.shape), 0)


def assert_identical(actual, expected):
    """Demand that two fits are the same to the last bit."""
    for field in fields(expected):
        if field.name != "model":
            own, other = (
                np.asarray(getattr(x, field.name)) for x in (actual, expected)
            )
            assert_array_equal(own, other, err_msg=field.name, strict=True)


# --- memory --------------------------------------------------------------------


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("known", [False, True])
def test_a_batch_takes_little_more_memory_than_its_data(kind, known):
    data = np.resize(noisy(2000), (60_000, NM.size)).astype(kind)
    sigma = np.full(NM.size, SIGMA) if known else None
    fit_skin(data[:10], NM, MODEL, uncertainty=sigma)  # tables read, code loaded
    tracemalloc.start()
    try:
        fit_skin(data, NM, MODEL, uncertainty=sigma)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert data.nbytes + peak <= MOST_MEMORY * data.nbytes


# --- many alike ----------------------------------------------------------------


def test_identical_spectra_are_fitted_identically():
    one = noisy(1)
    # As many as a large image has, without the memory for them.
    many = fit_skin(np.broadcast_to(one, (100_000, NM.size)), NM, MODEL)
    alone = fit_skin(one, NM, MODEL)
    for name in ("values", "covariance", "interval", "sse", "xyz", "status"):
        own = getattr(many, name)
        assert_array_equal(own, np.broadcast_to(getattr(alone, name), own.shape))


# --- kinds of arrays -----------------------------------------------------------


def read_only(data):
    """Return a copy that may not be written."""
    copy = data.copy()
    copy.flags.writeable = False
    return copy


def strided(data):
    """Return the data as every second number of another array."""
    wide = np.full((len(data), 2 * data.shape[1]), 0.9)
    wide[:, ::2] = data
    return wide[:, ::2]


def backwards(data):
    """Return the data with rows and bands stored the other way round."""
    return data[::-1, ::-1].copy()[::-1, ::-1]


def foreign(data):
    """Return the data in the other byte order."""
    return data.astype(data.dtype.newbyteorder())


@pytest.mark.parametrize(
    "kind",
    [read_only, strided, backwards, foreign, np.asfortranarray, np.ndarray.tolist],
)
@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_how_data_are_stored_does_not_show(kind, precision):
    data = noisy(300).astype(precision)
    stored = kind(data)
    assert_identical(
        fit_skin(stored, NM, MODEL), fit_skin(data.astype(float), NM, MODEL)
    )


@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_a_mapped_file_is_fitted_and_left_alone(tmp_path, precision):
    data = noisy(600).astype(precision)
    path = tmp_path / "cube.raw"
    data.tofile(path)
    before = path.read_bytes()
    cube = np.memmap(path, precision, "r", shape=(20, 30, NM.size))
    fit = fit_skin(cube, NM, MODEL)
    assert fit.status.shape == (20, 30)
    assert_array_equal(fit.values, fit_skin(data, NM, MODEL).values.reshape(20, 30, 3))
    assert path.read_bytes() == before


def test_images_stored_band_by_band_are_fitted():
    # As a line-scanner writes them: bands first in the file.
    cube = noisy(600).reshape(20, 30, NM.size)
    by_band = np.ascontiguousarray(np.moveaxis(cube, -1, 0))
    assert_identical(
        fit_skin(np.moveaxis(by_band, 0, -1), NM, MODEL), fit_skin(cube, NM, MODEL)
    )


def test_unsorted_parts_of_a_batch_are_fitted_as_the_whole_is():
    data = noisy(5000)
    order = np.random.default_rng(2).permutation(5000)
    assert_identical(fit_skin(data[order], NM, MODEL), fit_skin(data, NM, MODEL)[order])


# --- threads -------------------------------------------------------------------


def test_fits_at_the_same_time_do_not_disturb_each_other():
    batches = [noisy(3000, seed) for seed in range(6)]
    models = [skin_model(site=s, specular="included") for s in ("cheek", "inner arm")]
    jobs = [(batch, model) for batch in batches for model in models]
    expected = [fit_skin(batch, NM, model) for batch, model in jobs]
    with ThreadPoolExecutor(6) as pool:
        found = list(pool.map(lambda job: fit_skin(job[0], NM, job[1]), jobs))
    for own, alone in zip(found, expected, strict=True):
        assert_identical(own, alone)


class StopError(Exception):
    """What a progress bar may raise when its window is closed."""


def interrupt(_):
    """Do what Ctrl-C does."""
    signal.raise_signal(signal.SIGINT)


def fail(_):
    """Raise an error of the caller's own."""
    raise StopError


@pytest.mark.parametrize(
    ("advance", "error"), [(interrupt, KeyboardInterrupt), (fail, StopError)]
)
@pytest.mark.parametrize("n", [100, 30_000])
def test_a_fit_that_is_stopped_ends_its_threads(advance, error, n):
    data, threads = noisy(100), threading.active_count()
    told = []

    def stop(done):
        told.append(done)
        advance(done)

    with pytest.raises(error):
        fit_skin(np.resize(data, (n, NM.size)), NM, MODEL, advance=stop)
    assert len(told) == 1
    assert threading.active_count() == threads
    fit_skin(data, NM, MODEL).raise_for_status()


def test_progress_adds_up_to_the_batch():
    told = []
    fit_skin(np.resize(noisy(100), (10_001, NM.size)), NM, MODEL, advance=told.append)
    assert sum(told) == 10_001
    assert len(told) > 1
