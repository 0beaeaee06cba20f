# SPDX-License-Identifier: MIT
"""The phantom in every format that is read, written by other programs.

    formats_in.py ISOSHADE [CASE ...]   "ok NAME", "ok NAME # SKIP why" or "not ok NAME: why" a case, in the current folder
    formats_in.py --list                the names of the cases
"""
import sys

# Cases are entered, in this order, as their files are imported.
import formats_medical  # noqa: F401
import formats_dicom  # noqa: F401
import formats_pictures  # noqa: F401
import formats_arrays  # noqa: F401
import formats_matrix  # noqa: F401
import formats_science  # noqa: F401
from phantom import CASES, main

sys.exit(main(CASES))
