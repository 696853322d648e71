"""Makes files of testdata anew: `.venv/bin/python testdata/generate [NAME...]`, such as `make_cgns`; all but those that need netCDF4, OpenFOAM, libcgns or another
version of azimesh unless any is named. TESTDATA is the folder, where it is another than testdata. The same versions make the same files but for time stamps.
"""

import sys
from importlib import import_module

MADE = [
    "make_testdata", "make_vtkhdf", "make_vtk_files", "make_cgns", "make_fluent", "make_gmsh_versions", "make_gmsh_orders",
    "make_lagrange_orders", "make_medit_abaqus", "make_cell_quality",
]  # fmt: skip
ON_REQUEST = ["make_exodus", "make_openfoam", "make_records", "adf_library"]

for name in sys.argv[1:] or MADE:
    assert name in MADE + ON_REQUEST, f"{name} is none of {', '.join(MADE + ON_REQUEST)}"
    import_module(name).main()
