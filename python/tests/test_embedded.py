"""A program that embeds Python keeps its own SIGINT."""

import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

import azimesh

LIBRARIES = Path(sysconfig.get_config_var("LIBDIR") or "")
HEADERS = Path(sysconfig.get_paths()["include"])
NAME = f"python{sys.version_info.major}.{sys.version_info.minor}{getattr(sys, 'abiflags', '')}"

HOST = r"""
#include <Python.h>
#include <signal.h>

static volatile sig_atomic_t heard = 0;
static void hear(int signal) { (void)signal; heard++; }

static PyObject *count(PyObject *self, PyObject *none) {
    (void)self; (void)none;
    return PyLong_FromLong(heard);
}
static PyMethodDef functions[] = {{"heard", count, METH_NOARGS, ""}, {NULL, NULL, 0, NULL}};
static struct PyModuleDef module = {PyModuleDef_HEAD_INIT, "host", "", -1, functions, NULL, NULL, NULL, NULL};
static PyObject *make(void) { return PyModule_Create(&module); }

int main(int n, char **arguments) {
    struct sigaction mine = {0}, after;
    (void)n;
    mine.sa_handler = hear;
    sigaction(SIGINT, &mine, NULL);
    PyImport_AppendInittab("host", make);
    Py_InitializeEx(0);
    if (PyRun_SimpleString(arguments[1]) != 0) return 2;
    sigaction(SIGINT, NULL, &after);
    if (after.sa_handler != hear) return 3;
    return Py_FinalizeEx() < 0 ? 4 : 0;
}
"""

SCRIPT = """
import os, signal, sys, threading
sys.path[:0] = {path!r}
import host, azimesh
mesh = azimesh.read({mesh!r})
deformation = azimesh.Deformation(mesh, azimesh.Schedule({schedule!r}))
timer = threading.Timer(0.02, os.kill, (os.getpid(), signal.SIGINT))
timer.start()
while host.heard() == 0:
    lengths = [len(step.points) for step in deformation]
timer.join()
assert lengths == [mesh.n_points] * len(deformation)
assert azimesh.quality(mesh).summary["inverted"] == 0
"""


@pytest.mark.skipif(shutil.which("cc") is None or not (HEADERS / "Python.h").exists(), reason="no C compiler, or no headers of Python")
@pytest.mark.skipif(not (LIBRARIES / f"lib{NAME}.so").exists(), reason="this Python has no library to link")
def test_an_embedding_program_keeps_its_signals(tmp_path, testdata):
    source, host = tmp_path / "host.c", tmp_path / "host"
    source.write_text(HOST)
    subprocess.run(["cc", source, f"-I{HEADERS}", f"-L{LIBRARIES}", f"-Wl,-rpath,{LIBRARIES}", f"-l{NAME}", "-o", host], check=True)
    path = [entry for entry in sys.path if entry] + [str(Path(azimesh.__file__).parents[1])]
    script = SCRIPT.format(path=path, mesh=str(testdata / "naca0012.vtu"), schedule=str(testdata / "naca0012.toml"))
    assert subprocess.run([host, script], timeout=120).returncode == 0
