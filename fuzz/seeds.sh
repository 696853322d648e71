#!/bin/sh
# Fills the corpora with the small meshes and schedules of testdata/.
set -eu
cd "$(dirname "$0")"
mkdir -p corpus/ugrid corpus/schedule
for kind in vtu msh su2 vtk vtkhdf cgns pvtu; do
    mkdir -p "corpus/$kind"
    find ../testdata -name "*.$kind" -size -101k -exec cp {} "corpus/$kind/" \;
done
# The first byte of a UGRID input is the place of its flavour in the target's list.
flavour() {
    find ../testdata -name "*$2" -size -101k | while read -r file; do
        { printf "$1"; cat "$file"; } > "corpus/ugrid/$(basename "$file")"
    done
}
# The first byte of an OpenFOAM input is the place of its file in the target's list.
mkdir -p corpus/openfoam
which=0
seed() {
    file="../testdata/openfoam/$1/$2"
    [ -f "$file" ] && { printf "\\$(printf %03o "$which")"; cat "$file"; } > "corpus/openfoam/$(echo "$1_$2" | tr / _)"
    return 0
}
for name in points faces owner neighbour boundary cellZones; do
    for case in ascii binary wide_labels polyhedra; do
        seed "$case" "constant/polyMesh/$name"
    done
    which=$((which + 1))
done
for piece in decomposed/processor1 collated/processors2; do
    for name in points faces owner neighbour boundary cellZones \
        pointProcAddressing faceProcAddressing cellProcAddressing boundaryProcAddressing; do
        seed "${piece%/*}" "${piece#*/}/constant/polyMesh/$name"
        which=$((which + 1))
    done
done
flavour '\000' cells.ugrid
flavour '\001' .b8.ugrid
flavour '\004' .lb4.ugrid
flavour '\006' .lr8.ugrid
flavour '\012' .lb8l.ugrid
mkdir -p corpus/fluent
find ../testdata/fluent -type f ! -name '*.gz' -exec cp {} corpus/fluent/ \;
find ../testdata -name '*.vt[psri]' -exec cp {} corpus/vtu/ \;
find ../testdata -name '*.toml' -exec cp {} corpus/schedule/ \;
sed -n '/^```toml$/,/^```$/p' ../docs/schedule.md | grep -v '^```' > corpus/schedule/manual.toml
# No file of testdata/ is STL.
mkdir -p corpus/stl
printf 'solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1.5 0 0\nvertex 0 1e0 -0\nendloop\nendfacet\nendsolid a b\n' > corpus/stl/text
{ printf '%080d\001\000\000\000' 0; printf '%048d\000\000' 0; } > corpus/stl/binary
mkdir -p corpus/exodus
find ../testdata -name '*.exo' -exec cp {} corpus/exodus/ \;
mkdir -p corpus/medit corpus/abaqus
find ../testdata -name '*.mesh' -exec cp {} corpus/medit/ \;
find ../testdata -name '*.inp' -exec cp {} corpus/abaqus/ \;
# No file of testdata/ is Plot3D. The first byte of an input is the place of what is stated in the target's list; each is a
# cube of eight nodes, the binary ones of 32 bits and little-endian, with numbers that are the digit 0 four times.
mkdir -p corpus/plot3d
coordinates='0 1 0 1 0 1 0 1\n0 0 1 1 0 0 1 1\n0 0 0 0 1 1 1 1\n'
printf '\000 1\n 2 2 2\n%b' "$coordinates" > corpus/plot3d/text
printf '\001 2 2 2\n%b 1 1 1 1 0 1 1 1\n' "$coordinates" > corpus/plot3d/text_single_iblank
size='\002\000\000\000\002\000\000\000\002\000\000\000'
{ printf "\\002\\001\\000\\000\\000$size"; printf '%096d' 0; } > corpus/plot3d/binary
{ printf "\\000\\004\\000\\000\\000\\001\\000\\000\\000\\004\\000\\000\\000\\014\\000\\000\\000$size\\014\\000\\000\\000"
  printf '\140\000\000\000%096d\140\000\000\000' 0; } > corpus/plot3d/records
