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
# A task that is stopped a minute before its time is up, preempted or requeued goes on from its last
# finished step when it runs again.
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

# exec: Slurm's signal reaches azimesh, which finishes the step that it is writing.
exec azimesh deform "$mesh" "$schedule" --base "$base" -o "$out" --steps "$first..$end" --resume
