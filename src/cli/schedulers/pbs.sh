#!/bin/bash
#PBS -N {{name}}
#PBS -J 1-{{shards}}
#PBS -l select=1:ncpus=1
#PBS -l walltime={{clock}}
#PBS -r y
# Submit:                 qsub sweep.sh
# Again, what is missing: tumblenet sweep missing {{out}} --shards {{shards}}, each range with qsub -J FIRST-LAST sweep.sh
{{rest}}
cd "$PBS_O_WORKDIR"
exec tumblenet sweep {{study}} --out {{out}} --shard "$PBS_ARRAY_INDEX/{{shards}}" --jobs 1 --quiet
