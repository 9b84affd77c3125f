"""Fits a power law above a fixed cost to times: t = a + b x^k."""

import numpy

EXPONENTS = numpy.arange(0.05, 3.0001, 0.01)
# Times drawn anew, to say how well an exponent is known.
DRAWS = 400


def fit_all(x, times):
    """The fits with the least relative residuals, one for each row of times: arrays of a, b (of x / max x), k
    and the root mean square of the relative residuals; a, b >= 0. For every k it solves the normal equations
    of sum (w a + w p b - 1)^2, with w = 1 / t and p = x^k."""
    power = ((x / x.max())[:, None] ** EXPONENTS)[None]
    weight = (1.0 / times)[:, :, None]
    w, wp = weight.sum(1), (weight * power).sum(1)
    ww, wwp, wwpp = (weight ** 2).sum(1), (weight ** 2 * power).sum(1), (weight ** 2 * power ** 2).sum(1)
    determinant = numpy.maximum(ww * wwpp - wwp ** 2, 1e-12 * ww * wwpp)
    a, b = (w * wwpp - wp * wwp) / determinant, (wp * ww - w * wwp) / determinant
    # Where one were negative: the other one alone.
    a, b = (numpy.where(b < 0.0, w / ww, numpy.where(a < 0.0, 0.0, a)),
            numpy.where(b < 0.0, 0.0, numpy.where(a < 0.0, wp / wwpp, b)))
    residual = numpy.maximum(len(x) - a * w - b * wp, 0.0)
    rows, best = numpy.arange(len(times)), residual.argmin(axis=1)
    return (a[rows, best], b[rows, best], EXPONENTS[best],
            numpy.sqrt(residual[rows, best] / len(x)))


def medians_drawn_anew(samples, generator):
    """Medians of bootstrap samples: draws x cells."""
    return numpy.stack([numpy.median(generator.choice(cell, (DRAWS, len(cell))), axis=1)
                        for cell in samples], axis=1)


def fit(x, samples):
    """Fits the medians of the samples, one list of times for each x: a dict of `fixed` (a), `factor` (b of
    x / max x), `exponent` (k), `interval` (of k: it holds 90 % of the fits to samples drawn anew) and
    `deviation` (root mean square, relative)."""
    x, samples = numpy.asarray(x, float), [numpy.asarray(cell, float) for cell in samples]
    medians = numpy.array([numpy.median(cell) for cell in samples])
    if len(set(x)) < 4 or (x <= 0.0).any() or (medians <= 0.0).any():
        raise ValueError('an exponent and a fixed cost take four positive measurements at least')
    fixed, factor, exponent, deviation = (value[0] for value in fit_all(x, medians[None]))
    drawn = fit_all(x, medians_drawn_anew(samples, numpy.random.default_rng(1)))[2]
    return {'fixed': float(fixed), 'factor': float(factor), 'exponent': float(exponent),
            'interval': [float(bound) for bound in numpy.percentile(drawn, (5, 95))],
            'deviation': float(deviation)}


def evaluate(fitted, x, largest):
    """The fitted time at x, where the fit reached up to `largest`."""
    return fitted['fixed'] + fitted['factor'] * (numpy.asarray(x, float) / largest) ** fitted['exponent']
