#!/usr/bin/python3
"""Finite volumes of seepage under a sheet pile: the reference of ThinWalls.WaterSeepsUnderAPile (tests/fluid).

A layer of 2 m by 0.6 m on an impermeable base, between impermeable sides, heads of 0.9 and 0.7 m on its top, a pile from the top down to
0.3 m. The heads are antisymmetric about the pile, so that one half is solved, with the mean head on the line below the pile's tip.
Prints the discharge [m2/s] with 60, 120 and 240 rows and the limit to which their differences point.
"""

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg

WIDTH, HEIGHT, TIP, HEADS, CONDUCTIVITY = 2.0, 0.6, 0.3, 0.2, 1e-4  # m, m, m above the base, m apart, m/s


def discharge(thickness, rows):
    """Discharge [m2/s], from half of the layer, in square cells; thickness [m] of the pile: a multiple of two cells."""
    cell = HEIGHT / rows
    columns = round(0.5 * WIDTH / cell)
    behind, below = round(0.5 * thickness / cell), round(TIP / cell)
    soil = np.ones((columns, rows), bool)
    soil[:behind, below:] = False
    number = np.full(soil.shape, -1)
    number[soil] = np.arange(soil.sum())
    pairs = []
    for a, b in ((number[:-1], number[1:]), (number[:, :-1], number[:, 1:])):
        joined = (a >= 0) & (b >= 0)
        pairs.append((a[joined], b[joined]))
    first, second = (np.concatenate(side) for side in zip(*pairs))
    one = np.ones(len(first))
    links = sparse.coo_matrix((one, (first, second)), (soil.sum(),) * 2)
    links = links + links.T
    top, middle = number[behind:, -1], number[0, :below]
    held = np.zeros(soil.sum())  # half a cell from a prescribed head: twice the conductance
    held[top] += 2.0
    held[middle] += 2.0
    given = np.zeros(soil.sum())
    given[top] = 2.0 * 0.5 * HEADS
    matrix = sparse.diags(np.asarray(links.sum(axis=1)).ravel() + held) - links
    head = sparse.linalg.spsolve(matrix.tocsc(), given)
    return CONDUCTIVITY * np.sum(2.0 * (0.5 * HEADS - head[top]))


if __name__ == "__main__":
    for thickness in (0.08, 0.04, 0.02, 0.0):
        coarse, middle, fine = (discharge(thickness, rows) for rows in (60, 120, 240))
        limit = fine + (fine - middle) ** 2 / ((middle - coarse) - (fine - middle))
        print(f"{thickness:.2f} m thick: {coarse:.4e} {middle:.4e} {fine:.4e}, in the limit {limit:.4e}")
