#!/bin/bash
#HQ --name={{name}}
#HQ --array=1-{{shards}}
#HQ --cpus=1
#HQ --time-limit={{minutes}}m
# Submit:                 hq submit sweep.sh
# Again, what is missing: hq submit --array "$(tumblenet sweep missing {{out}} --shards {{shards}})" sweep.sh
{{rest}}
exec tumblenet sweep {{study}} --out {{out}} --shard "$HQ_TASK_ID/{{shards}}" --jobs 1 --quiet
