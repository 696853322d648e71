#!/bin/bash
#SBATCH --job-name=azimesh
#SBATCH --array=1-9
#SBATCH --cpus-per-task=4
#SBATCH --mem=8G
#SBATCH --requeue
#SBATCH --signal=B:TERM@60
#
# One of 9 slabs of a mesh for each task of a Slurm array; tasks run in any order, at once or not:
#
#     job=$(sbatch --parsable slurm_slabs.sh wing.cgns wing.toml out 9)
#     sbatch --dependency=afterok:$job --mem=8G --wrap "azimesh finish out"
#
# A task that is stopped, preempted or requeued goes on after its last finished step when it runs again; `sbatch --array=3,7` runs
# some of them again.
set -euo pipefail
# In the place of this shell, so that Slurm's signal reaches azimesh, which finishes the step that it is writing.
exec azimesh deform "$1" "$2" -o "$3" --slab "$SLURM_ARRAY_TASK_ID/$4" --resume
