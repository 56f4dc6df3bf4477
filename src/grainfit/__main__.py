"""Makes ``python -m grainfit`` the same as ``grainfit``."""

from grainfit.cli import main

if __name__ == "__main__":
    main()
