#!/bin/sh
# Fills the corpora with the small meshes and schedules of testdata/.
set -eu
cd "$(dirname "$0")"
mkdir -p corpus/ugrid corpus/vtu corpus/msh corpus/su2 corpus/schedule
for kind in vtu msh su2; do
    find ../testdata -name "*.$kind" -size -40k -exec cp {} "corpus/$kind/" \;
done
# The first byte of a UGRID input is the place of its flavour in the target's list.
flavour() {
    find ../testdata -name "*$2" -size -40k | while read -r file; do
        { printf "$1"; cat "$file"; } > "corpus/ugrid/$(basename "$file")"
    done
}
flavour '\000' cells.ugrid
flavour '\001' .b8.ugrid
flavour '\004' .lb4.ugrid
flavour '\006' .lr8.ugrid
flavour '\012' .lb8l.ugrid
find ../testdata -name '*.toml' -exec cp {} corpus/schedule/ \;
sed -n '/^```toml$/,/^```$/p' ../docs/schedule.md | grep -v '^```' > corpus/schedule/manual.toml
