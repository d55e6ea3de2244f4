"""`python -m clearsweep` is the same as `clearsweep`."""

from clearsweep.cli import main

if __name__ == "__main__":
    main()
