"""`python -m clearsweep` is the same as `clearsweep`."""

from .cli import main

if __name__ == "__main__":
    main()
