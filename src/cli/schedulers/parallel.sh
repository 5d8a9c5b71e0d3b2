#!/bin/bash
# Start, and start again for what is missing: bash sweep.sh
# On other machines with the same folder: bash sweep.sh --sshlogin node1,node2 --workdir .
{{rest}}
seq 1 {{shards}} | parallel "$@" --timeout {{seconds}} \
  tumblenet sweep {{study_again}} --out {{out_again}} --shard {}/{{shards}} --jobs 1 --quiet
