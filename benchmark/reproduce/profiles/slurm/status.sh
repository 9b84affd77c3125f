#!/usr/bin/env bash
# status.sh JOB: says whether a job of SLURM's is running, success or failed, as Snakemake asks. A job that was
# cancelled, or of which nobody knows, has failed: it is done once more.
job=${1%%;*}
# The first state is the job's own; those of its steps follow. Not every cluster keeps accounts.
state=$(sacct --jobs "$job" --format State --noheader --parsable2 2>/dev/null | head -n 1)
if [[ -z $state ]]; then
  state=$(squeue --jobs "$job" --states all --format %T --noheader 2>/dev/null | head -n 1)
fi
case ${state%% *} in
  COMPLETED) echo success ;;
  PENDING | CONFIGURING | RUNNING | COMPLETING | SUSPENDED | REQUEUED | REQUEUE_HOLD | REQUEUE_FED | RESIZING | \
    STAGE_OUT | SIGNALING | STOPPED | RESV_DEL_HOLD | SPECIAL_EXIT) echo running ;;
  "")
    # The controller may be away for a moment: then nobody knows, and the answer comes later.
    if scontrol ping 2>/dev/null | grep -q "is UP"; then echo failed; else echo running; fi
    ;;
  *) echo failed ;;
esac
