"""Every metric of every mesh of testdata, and of real ones, against VTK's: `validation/check_quality.py` on all of them."""

import subprocess
import sys

from formats import sources
from meshes import third_party
from program import AZIMESH, real_meshes

JUDGED = {5, 9, 10, 12, 13, 14}
# Meshes by others with cells of all kinds: boundary layers, surfaces in space, flat and tangled cells among them.
REAL = [
    "su2code__TestCases/hom_navierstokes/SphereViscous/nPoly1/SphereViscous_Linear.su2.gz",
    "su2code__TestCases/incomp_navierstokes/sphere/slice_2syms.su2",
    "su2code__TestCases/deformation/brick_hex/mesh_brick_hex_ffd.su2",
    "su2code__TestCases/actuator_disk/ActuatorDisk_I.su2",
    "su2code__TestCases/navierstokes/naca0012/mesh_NACA0012_lam_hybrid_v1.su2",
    "su2code__TestCases/aeroelastic/mesh_NACA64A010_hybrid_inv.su2",
    "su2code__TestCases/fea_fsi/Airfoil_RBF/mesh.su2",
    "gen_openfoam1912/wingMotion2D/wingMotion2D_tagged.vtu",
    "gen_openfoam1912/wingMotion2D/internal_with_polyhedra.vtu",
    "gen_openfoam1912/naca0012_adjoint/naca0012_tagged.vtu",
    "gen_gmsh4.15/wing_fuselage_12k.cgns",
    "gen_gmsh4.15/naca12BL_v41_bin.msh",
    "gen_adf2hdf_libcgns3.4/FVENS_n0012_113-33_hex.h5.cgns",
    "gen_adf2hdf_libcgns3.4/SU2_mesh_bend_coarse.h5.cgns",
    "gen_adf2hdf_libcgns3.4/mdolab_717_wl_L2_structured.h5.cgns",
    "pyvista__vtk-data/Data/AngularSector.vtk",
    "Slaedr__FVENS/testcases/visc-cylinder/grids/2dcylinderhybrid3.msh",
    "Slaedr__amovemesh/input/qin-mesh.msh",
    "dealii__dealii/examples/step-97/sphere_r6.msh",
    "dealii__dealii/examples/step-70/impeller.vtk",
    "dealii__dealii/tests/mesquite/mesh/3d/hex_5_tangled.vtk",
    "dealii__dealii/tests/mesquite/mesh/2d/hole_in_square_tanglap.vtk",
    "debian_gmsh-4.8.4/benchmarks/3d/discrete.msh",
    "mfem__mfem/data/sphere.msh",
]


def judged():
    """Meshes with cells that VTK's mesh quality knows: neither second-order ones nor polyhedra."""
    return [path for path in sources() if {kind for kind, _ in third_party(path).volume_cells} & JUDGED]


def main():
    """One line a mesh, then a table over all."""
    real = real_meshes()
    if real is None:
        print("quality: AZIMESH_TESTDATA is not set: real meshes are SKIPPED", file=sys.stderr)
    paths = judged() + ([] if real is None else [real / name for name in REAL])
    command = [sys.executable, "validation/check_quality.py", "--total", "--azimesh", AZIMESH, *map(str, paths)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    print(done.stdout, end="", flush=True)
    assert done.returncode == 0, "cell quality differs from VTK's"


if __name__ == "__main__":
    main()
