#!/bin/bash
# One mesh on several machines: sbatch slurm_mpi.sh MESH SCHEDULE FOLDER
# azimesh was built with --features mpi. A job that was stopped is submitted again as it is.
#SBATCH --nodes=4
#SBATCH --ntasks-per-node=1
#SBATCH --cpus-per-task=32
#SBATCH --signal=TERM@60
set -u
exec srun --cpus-per-task="$SLURM_CPUS_PER_TASK" azimesh deform "$1" "$2" -o "$3" --resume
