"""Work on slices of arrays, in as many threads as there are processors for it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor


def in_slices(
    work: Callable[[slice], object],
    n: int,
    size: int,
    advance: Callable[[int], object] | None = None,
) -> None:
    """Call ``work`` on slices of at most ``size`` that together cover ``n`` rows.

    Parameters
    ----------
    work : callable
        Takes a slice of rows. It gains from threads where it releases the GIL.
    n, size : int
        Rows in all and in a slice.
    advance : callable, optional
        Told the number of rows of each slice that is done, in order.
    """
    slices = [slice(i, min(i + size, n)) for i in range(0, n, size)]
    threads = min(len(slices), processors())
    if threads <= 1:
        done = map(work, slices)
        _report(done, slices, advance)
        return
    with ThreadPoolExecutor(threads) as pool:
        try:
            _report(pool.map(work, slices), slices, advance)
        except BaseException:
            pool.shutdown(cancel_futures=True)  # what has begun ends, the rest does not
            raise


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def even_size(n: int, most: int) -> int:
    """Return a size of slices of ``n`` rows, at most ``most``, that keeps all busy.

    Every processor gets as many slices, or the last would be worked on alone.
    """
    rounds = -(-n // (most * processors()))
    return max(1, -(-n // max(1, rounds * processors())))


def _report(
    results: Iterable[object],
    slices: list[slice],
    advance: Callable[[int], object] | None,
) -> None:
    """Wait for the results, telling each slice that is done."""
    for _, part in zip(results, slices, strict=True):
        if advance is not None:
            advance(part.stop - part.start)
