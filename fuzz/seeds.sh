#!/bin/sh
# Fills the corpora with the small meshes and schedules of testdata/.
set -eu
cd "$(dirname "$0")"
mkdir -p corpus/vtu corpus/msh corpus/su2 corpus/schedule
for kind in vtu msh su2; do
    find ../testdata -name "*.$kind" -size -40k -exec cp {} "corpus/$kind/" \;
done
find ../testdata -name '*.toml' -exec cp {} corpus/schedule/ \;
sed -n '/^```toml$/,/^```$/p' ../docs/schedule.md | grep -v '^```' > corpus/schedule/manual.toml
