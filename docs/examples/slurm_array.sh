#!/bin/bash
#SBATCH --job-name=azimesh
#SBATCH --array=0-8
#SBATCH --cpus-per-task=4
#SBATCH --requeue
#SBATCH --signal=B:TERM@60
#
# One part of a sequence for each task of a Slurm array, from one base.toml:
#
#     azimesh select wing.cgns wing.toml -o base.toml
#     job=$(sbatch --parsable slurm_array.sh wing.cgns wing.toml base.toml out)
#     sbatch --dependency=afterok:$job --wrap "azimesh finish out"
#
# A task that is stopped a minute before its time is up, preempted or requeued resumes from its last
# finished step when it runs again. A task that fails a check (inverted cells, say) is finished: the job
# with `azimesh finish` runs, and ends with 1.
set -euo pipefail
mesh=$1 schedule=$2 base=$3 out=$4

steps=$(azimesh check "$mesh" "$schedule" | awk '$1 == "steps" { print $2 }')
task=$((SLURM_ARRAY_TASK_ID - ${SLURM_ARRAY_TASK_MIN:-0}))
tasks=$SLURM_ARRAY_TASK_COUNT
first=$((task * steps / tasks))
end=$(((task + 1) * steps / tasks))
if [ "$first" -eq "$end" ]; then
    echo "more tasks than steps: nothing to do for task $task"
    exit 0
fi

# Slurm's signal reaches this shell. It is passed on to azimesh, which finishes the step that it is
# writing; the shell waits for it.
asked='' deform=''
trap 'asked=yes; [ -z "$deform" ] || kill -TERM "$deform" || true' TERM
azimesh deform "$mesh" "$schedule" --base "$base" -o "$out" --steps "$first..$end" --resume &
deform=$!
[ -z "$asked" ] || kill -TERM "$deform" || true
code=0
wait "$deform" || code=$?
while [ -n "$asked" ]; do
    # The signal has ended `wait`, not azimesh.
    asked='' code=0
    wait "$deform" || code=$?
done
if [ "$code" -eq 1 ]; then
    echo "steps $first..$end: a check failed; azimesh finish tells of it, and of steps that are missing" >&2
    exit 0
fi
exit "$code"
