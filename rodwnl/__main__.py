"""`python -m rodwnl` is the command `rodwnl`."""

import sys


def main() -> None:
    from rodwnl.cli import run

    sys.exit(run(sys.argv[1:]))


if __name__ == "__main__":
    main()
