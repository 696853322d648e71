#!/bin/sh
# Builds libazimeshMotion.so with the libraries of Debian's package openfoam and the headers of its sources.
#
#     ./build.sh FOLDER_OF_THE_SOURCES
set -eu
sources=${1:?the folder of the OpenFOAM sources}/src
here=$(cd "$(dirname "$0")" && pwd)
include=
for library in OpenFOAM OSspecific/POSIX meshTools dynamicMesh; do
    [ -d "$sources/$library/lnInclude" ] || "$sources/../wmake/wmakeLnInclude" "$sources/$library" > /dev/null 2>&1
    include="$include -isystem $sources/$library/lnInclude"
done
# shellcheck disable=SC2086
g++ -std=c++11 -O2 -fPIC -shared -DOPENFOAM=1912 -DWM_DP -DWM_LABEL_SIZE=32 -DNoRepository $include \
    "$here/azimeshMotionSolver.C" -o "$here/libazimeshMotion.so" -ldynamicMesh -lmeshTools -lOpenFOAM
echo "$here/libazimeshMotion.so"
