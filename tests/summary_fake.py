"""What a made-up run reads of its summary, a frame, as the store reads it column by column."""

import pandas as pd


class OfFrame:
    """The reading side of a store whose summary is the frame `summary`, its units in `attrs`."""

    seek = optimise = identify = None  # nothing is searched for, optimised or identified
    worst = ()  # no revolution of a peak is saved

    @property
    def columns(self):
        """Return the names of the columns."""
        return list(self.summary.columns)

    @property
    def units(self):
        """Return the unit of every column that has one."""
        return self.summary.attrs["units"]

    def blocks(self, columns):
        """Yield all rows at once."""
        yield {name: self.summary[name].to_numpy() for name in columns}

    def column(self, name):
        """Return one column."""
        return self.summary[name]

    def event_blocks(self):
        """Yield nothing: no events were kept."""
        yield from ()

    def poincare(self, case_id):
        """Return that nothing was kept at crank angle 0."""
        return pd.DataFrame()
