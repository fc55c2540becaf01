#!/bin/sh
# scripts/in_time.sh COMMAND...: runs the command, unless the time $PORETWIN_VERIFY_UNTIL (seconds since 1970) has passed: then the exit
# code is 77, by which CTest counts a test as skipped. Without that variable the command always runs.
if [ -n "$PORETWIN_VERIFY_UNTIL" ] && [ "$(date +%s)" -ge "$PORETWIN_VERIFY_UNTIL" ]; then
  echo "left out: the time for verifications has passed"
  exit 77
fi
exec "$@"
