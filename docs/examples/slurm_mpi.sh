#!/bin/bash
# One mesh on several machines: sbatch slurm_mpi.sh MESH SCHEDULE FOLDER
# azimesh was built with --features mpi. A job that was stopped is submitted again as it is.
#SBATCH --nodes=4
#SBATCH --ntasks-per-node=1
#SBATCH --cpus-per-task=32
#SBATCH --signal=TERM@60
set -u
# Without --mpi the processes of some sites do not find each other; `srun --mpi=list` names what there is.
exec srun --kill-on-bad-exit=1 --mpi=pmix --cpus-per-task="$SLURM_CPUS_PER_TASK" azimesh deform "$1" "$2" -o "$3" --resume
