"""Writes testdata/exodus_hdf5.exo and exodus_cdf5.exo with netCDF's own library: the small mesh of tests/suite/support/exodus.rs, in HDF5 compressed.
"""

import netCDF4
import numpy as np

from place import FOLDER

NAMES = 33


def main():
    for name, stored in (("exodus_hdf5.exo", "NETCDF4"), ("exodus_cdf5.exo", "NETCDF3_64BIT_DATA")):
        with netCDF4.Dataset(FOLDER / name, "w", format=stored) as file:
            file.api_version = np.float32(8.03)
            file.floating_point_word_size = np.int32(8)
            mesh(file)
            sets(file)
            results(file)


def variable(file, name, kind, dimensions, values, element_type=None):
    made = file.createVariable(name, kind, dimensions, zlib="time_step" in dimensions)
    if element_type:
        made.elem_type = element_type
    made[...] = values


def names(file, variable_name, dimension, lines):
    made = file.createVariable(variable_name, "S1", (dimension, "len_string"))
    made[:] = np.array([list(line.ljust(NAMES, "\0")) for line in lines], dtype="S1")


def dimensions(file, **lengths):
    for name, n in lengths.items():
        file.createDimension(name, n)


def mesh(file):
    dimensions(file, len_string=NAMES, time_step=None, num_dim=3, num_nodes=16, num_elem=5, num_el_blk=5, num_fa_blk=1)
    dimensions(file, num_el_in_blk1=1, num_nod_per_el1=4, num_el_in_blk2=1, num_nod_per_el2=6, num_el_in_blk4=1)
    dimensions(file, num_fac_per_el4=4, num_el_in_blk5=2, num_nod_per_el5=3, num_fa_in_blk1=4, num_nod_per_fa1=12)
    i = np.arange(16.0)
    for name, axis in (("coordx", i), ("coordy", 0 * i + 0.5), ("coordz", -i * i)):
        variable(file, name, "f8", ("num_nodes",), axis)
    variable(file, "node_num_map", "i8", ("num_nodes",), 100 + np.arange(16))
    variable(file, "elem_num_map", "i8", ("num_elem",), 1 + np.arange(5))
    variable(file, "eb_prop1", "i8", ("num_el_blk",), [10, 20, 30, 40, 50])
    names(file, "eb_names", "num_el_blk", ["air", "", "nothing", "cells", "skin"])
    nodes = ("num_el_in_blk1", "num_nod_per_el1")
    variable(file, "connect1", "i8", nodes, [[1, 2, 3, 4]], "TETRA")
    nodes = ("num_el_in_blk2", "num_nod_per_el2")
    variable(file, "connect2", "i4", nodes, [[1, 2, 3, 4, 5, 6]], "WEDGE6")
    variable(file, "facconn4", "i4", ("num_fac_per_el4",), [1, 2, 3, 4], "nfaced")
    variable(file, "ebepecnt4", "i4", ("num_el_in_blk4",), [4])
    nodes = [6, 7, 8, 6, 7, 9, 7, 8, 9, 6, 8, 9]
    variable(file, "fbconn1", "i4", ("num_nod_per_fa1",), nodes, "nsided")
    variable(file, "fbepecnt1", "i4", ("num_fa_in_blk1",), [3] * 4)
    nodes = ("num_el_in_blk5", "num_nod_per_el5")
    variable(file, "connect5", "i4", nodes, [[10, 11, 12], [11, 12, 13]], "SHELL3")


def sets(file):
    dimensions(file, num_side_sets=3, num_node_sets=1, num_side_ss1=2, num_side_ss2=2, num_nod_ns1=3)
    variable(file, "ss_prop1", "i4", ("num_side_sets",), [7, 8, 9])
    names(file, "ss_names", "num_side_sets", ["upper wall", "", "never"])
    variable(file, "elem_ss1", "i8", ("num_side_ss1",), [1, 2])
    variable(file, "side_ss1", "i8", ("num_side_ss1",), [4, 1])
    variable(file, "elem_ss2", "i4", ("num_side_ss2",), [3, 4])
    variable(file, "side_ss2", "i4", ("num_side_ss2",), [2, 1])
    variable(file, "ns_prop1", "i4", ("num_node_sets",), [3])
    variable(file, "node_ns1", "i4", ("num_nod_ns1",), [1, 2, 3])


def results(file):
    dimensions(file, num_nod_var=4, num_elem_var=1, num_glo_var=2)
    variable(file, "time_whole", "f8", ("time_step",), [0.25, 0.5])
    names(file, "name_nod_var", "num_nod_var", ["displ_x", "displ_y", "displ_z", "p"])
    for i in range(4):
        values = [[100 * time + 10 * i + node / 16 for node in range(16)] for time in range(2)]
        variable(file, f"vals_nod_var{i + 1}", "f8", ("time_step", "num_nodes"), values)
    names(file, "name_elem_var", "num_elem_var", ["stress"])
    variable(file, "vals_elem_var1eb1", "f4", ("time_step", "num_el_in_blk1"), [[1], [2]])
    variable(file, "vals_elem_var1eb5", "f4", ("time_step", "num_el_in_blk5"), [[3, 4], [5, 6]])
    names(file, "name_glo_var", "num_glo_var", ["mass", "energy"])
    variable(file, "vals_glo_var", "f8", ("time_step", "num_glo_var"), [[1, 2], [3, 4]])
