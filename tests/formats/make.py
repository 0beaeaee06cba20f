# SPDX-License-Identifier: MIT
"""make.py - makes phantom.cube and phantom.xsf in this folder, by ASE 3.22.1 of Debian 12 (python3-ase). Their values are
those of phantom.py in its small size."""
import os

import numpy as np
from ase import Atoms
from ase.io.cube import write_cube
from ase.io.xsf import write_xsf

here = os.path.dirname(os.path.abspath(__file__))
n = (4, 5, 3)
x, y, z = np.meshgrid(*(np.arange(k) for k in n), indexing="ij")
values = 0.25 * x - 0.5 * y * y + 0.125 * z * x + 3 * z
cell = np.array([[2.0, 0.0, 0.0], [0.5, 2.5, 0.0], [0.25, -0.75, 1.5]])  # angstrom
atoms = Atoms("HO", positions=[[0.5, 0.5, 0.5], [1, 1, 1]], cell=cell, pbc=True)
with open(os.path.join(here, "phantom.cube"), "w", encoding="ascii") as file:
    write_cube(file, atoms, values, origin=[0.1, -0.2, 0.3], comment="made by ASE 3.22.1")
with open(os.path.join(here, "phantom.xsf"), "w", encoding="ascii") as file:
    write_xsf(file, [atoms], values)
