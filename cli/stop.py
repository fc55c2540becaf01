"""How `poretwin plot` and `poretwin report` end where something is wrong: with one line and an exit code (docs/protocol.md#exit-codes)."""
import sys

WRONG_COMMAND = 2  # the command line, or a case, is wrong
NO_FILE = 5        # a file or program is missing, or cannot be read


class Stop(SystemExit):
    def __init__(self, exit_code, message):
        super().__init__(message)
        self.exit_code = exit_code


def exit_with(main):
    """Runs the main function of a program and exits with the code that it returns, or with that of a Stop."""
    try:
        sys.exit(main())
    except Stop as stop:
        print(stop, file=sys.stderr)
        sys.exit(stop.exit_code)
