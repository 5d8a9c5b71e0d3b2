#!/bin/bash
#SBATCH --job-name={{name}}
#SBATCH --array=1-{{shards}}
#SBATCH --cpus-per-task=1
#SBATCH --time={{minutes}}
#SBATCH --requeue
# Submit:                 sbatch sweep.sh
# Again, what is missing: sbatch --array="$(tumblenet sweep missing {{out}} --shards {{shards}})" sweep.sh
{{rest}}
exec tumblenet sweep {{study}} --out {{out}} --shard "$SLURM_ARRAY_TASK_ID/{{shards}}" --jobs 1 --quiet
