"""Entry point of the command line, as `stickslip` and as `python -m stickslip`."""

import sys

INTERRUPTED = 130
"""Exit code, as of `stickslip.support.console`, which is not yet there."""


def main() -> None:
    """The command line. Ctrl-C while its modules load ends without a traceback, as it does later."""
    try:
        from stickslip.support.library_settings import import_nothing_from_working_folder

        import_nothing_from_working_folder()
        from stickslip.cli import main as command_line
    except BaseException as error:
        from stickslip.support.interrupts import is_behind

        if not is_behind(error):
            raise
        sys.stderr.write("Interrupted. All files written so far are complete.\n")
        sys.exit(INTERRUPTED)
    command_line()


if __name__ == "__main__":
    if not sys.flags.safe_path:
        del sys.path[0]  # by `python -m` the working folder, which may be that of a model
    main()
