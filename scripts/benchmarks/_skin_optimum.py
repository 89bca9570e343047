"""Is it the best there is? The fit against SciPy from several starts."""

import numpy as np
from _print import Row
from _skin_data import NM, Batch, hard, real
from _skin_scipy import STARTS, best_sse

from skinviz.skin.fit import fit_skin

SAME = 1e-6


def rows(n_real: int, n_hard: int) -> list[Row]:
    """Return the share of spectra whose sum of squares none of SciPy's beats."""
    thinned = [
        Batch(b.name, b.model, b.spectra[:: max(1, len(b.spectra) // n_real)][:n_real])
        for b in real()
    ]
    gaps, told, worst = [], [], []
    for batch in (*thinned, *hard(n_hard)):
        fit = fit_skin(batch.spectra, NM, batch.model)
        gap = fit.sse / best_sse(batch, fit.values) - 1
        gaps.append(gap)
        told.append(f"{batch.name} {(gap <= SAME).mean():.2%}")
        i = int(np.argmax(gap))
        worst.append((gap[i], batch.name, fit.values[i], str(fit.status[i])))
    pooled = np.concatenate(gaps)
    most, name, values, status = max(worst, key=lambda one: one[0])
    return [
        Row(
            f"SSE within 1e-6 of the best of {len(STARTS) + 1} SciPy starts, "
            f"{pooled.size:,} spectra",
            "99.9 %",
            f"{(pooled <= SAME).mean():.2%} ({', '.join(told)}); worst {most:.1e}: "
            f"{name}, weights {np.array2string(values, precision=4)}, {status}",
        )
    ]
