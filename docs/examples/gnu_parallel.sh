#!/bin/bash
#
# A sequence in parts that GNU parallel runs side by side, from one base.toml:
#
#     azimesh select wing.cgns wing.toml -o base.toml
#     ./gnu_parallel.sh wing.cgns wing.toml base.toml out 8
#
# After it was stopped, run it again: it resumes from the finished steps. With --sshlogin of
# parallel the parts run on several machines that share the folder. Exit code 1: everything is there,
# but a check failed, as for inverted cells.
set -euo pipefail
mesh=$1 schedule=$2 base=$3 out=$4 parts=$5
threads=$(($(nproc) / parts))

steps=$(azimesh check "$mesh" "$schedule" | awk '$1 == "steps" { print $2 }')
ranges() {
    local part
    for ((part = 0; part < parts; part++)); do
        echo "$((part * steps / parts))..$(((part + 1) * steps / parts))"
    done
}

# A part with exit code 1 has failed a check and is complete: the other parts and `finish`, which
# then ends with 1, still run.
deform=$(printf '%q ' azimesh deform "$mesh" "$schedule" --base "$base" -o "$out" --resume \
    --threads "$((threads > 0 ? threads : 1))")
export PARALLEL_SHELL=/bin/bash
ranges | parallel --jobs "$parts" --halt soon,fail=1 \
    "$deform --steps {} || { code=\$?; [ \$code -eq 1 ] || exit \$code; }"
azimesh finish "$out"
