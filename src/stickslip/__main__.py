"""Entry point of `python -m stickslip`, the command line."""

from stickslip.cli import main

if __name__ == "__main__":
    main()
