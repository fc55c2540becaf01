#!/usr/bin/python3
"""Computes seepage under a sheet pile by finite volumes: the reference of the test ThinWalls.WaterSeepsUnderAPile (tests/fluid).

A layer of 2 m by 0.6 m lies on an impermeable base, between impermeable sides. On its top the head is 0.9 m on one side of the pile and
0.7 m on the other. The pile reaches from the top down to 0.3 m above the base. Heads less their mean are antisymmetric about the pile,
so that only one half is solved, with the mean head on the line below the pile's tip. Prints the discharge [m2/s] for several
thicknesses of the pile, with 60, 120 and 240 rows of cells, and the limit to which the three values converge.
"""

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg

WIDTH, HEIGHT, TIP, HEADS, CONDUCTIVITY = 2.0, 0.6, 0.3, 0.2, 1e-4  # m, m, m above the base, m apart, m/s


def discharge(thickness, rows):
    """Discharge [m2/s], from half of the layer, in square cells, `rows` over the height. thickness [m]: of the pile, an even number of
    cells."""
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
    held = np.zeros(soil.sum())  # at half a cell from a prescribed head the conductance is twice that between cells
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
