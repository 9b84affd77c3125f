"""Fits a power law above a fixed cost to times: t = a + b x^k."""

import numpy

EXPONENTS = numpy.arange(0.05, 3.0001, 0.01)


def fit_linear(power, time):
    """a, b >= 0 and the sum of squared relative residuals of t = a + b * power."""
    weight = 1.0 / time
    candidates = []
    columns = numpy.stack([weight, weight * power], axis=1)
    both = numpy.linalg.lstsq(columns, numpy.ones_like(time), rcond=None)[0]
    if (both >= 0.0).all():
        candidates.append(both)
    # On the edge of what is allowed: no fixed cost, or nothing but.
    for only in (0, 1):
        column = columns[:, only]
        edge = numpy.zeros(2)
        edge[only] = column.sum() / (column @ column)
        candidates.append(edge)

    def residual(solution):
        return float(numpy.sum((columns @ solution - 1.0) ** 2))
    best = min(candidates, key=residual)
    return best[0], best[1], residual(best)


def fit(x, time):
    """The fit with the least relative residuals: a dict of `fixed` (a), `factor` (b of x / max x),
    `exponent` (k), `deviation` (root mean square, relative) and `loglog`, the slope of the straight line
    through the logarithms, which has no fixed cost."""
    x, time = numpy.asarray(x, float), numpy.asarray(time, float)
    if len(set(x)) < 4 or (x <= 0.0).any() or (time <= 0.0).any():
        raise ValueError('an exponent and a fixed cost take four positive measurements at least')
    relative = x / x.max()
    fits = [fit_linear(relative ** exponent, time) for exponent in EXPONENTS]
    best = min(range(len(fits)), key=lambda i: fits[i][2])
    fixed, factor, residual = fits[best]
    return {'fixed': float(fixed), 'factor': float(factor), 'exponent': float(EXPONENTS[best]),
            'deviation': float(numpy.sqrt(residual / len(x))),
            'loglog': float(numpy.polyfit(numpy.log(x), numpy.log(time), 1)[0])}


def evaluate(fitted, x, largest):
    """The fitted time at x, where the fit reached up to `largest`."""
    return fitted['fixed'] + fitted['factor'] * (numpy.asarray(x, float) / largest) ** fitted['exponent']
