"""The Hough transform of points, as figures 4 and 5 draw it."""

import numpy


def rho(point, angles):
    """Distances from the origin of the lines through a point, by the direction of their normal."""
    return point[0] * numpy.cos(angles) + point[1] * numpy.sin(angles)


def domain(points, columns, cell):
    """Votes of the points for lines, [rho, angle], with the edges of rho; angles are over [0, pi)."""
    angles = numpy.arange(columns) * numpy.pi / columns
    reach = numpy.ceil(numpy.hypot(points[:, 0], points[:, 1]).max() / cell) * cell
    edges = numpy.linspace(-reach, reach, round(2.0 * reach / cell) + 1)
    lines = numpy.outer(points[:, 0], numpy.cos(angles)) + numpy.outer(points[:, 1], numpy.sin(angles))
    votes = numpy.stack([numpy.histogram(lines[:, i], edges)[0] for i in range(columns)], axis=1)
    return votes, edges
