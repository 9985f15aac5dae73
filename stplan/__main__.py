"""``python -m stplan``."""

from stplan.cli import main

if __name__ == "__main__":
    main()
