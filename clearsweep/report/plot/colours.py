"""Colours of drawings: scales that turn numbers into colours, and images of coloured cells."""

import base64
import struct
import zlib
from typing import Any, NamedTuple

import numpy as np


def _anchors(codes: str) -> tuple[str, ...]:
    return tuple(f"#{code}" for code in codes.split())


#: Colours at equal distances; those between them are blended.  viridis: van der Walt and Smith 2015, CC0.
VIRIDIS = _anchors(
    "440154 470d60 48186a 482374 472d7b 453781 424086 3e4989 3b528b 375b8d 33638d 2f6b8e 2c728e 297a8e 26828e 23898e "
    "21918c 1f988b 1fa088 22a785 28ae80 32b67a 3fbc73 4ec36b 5ec962 70cf57 84d44b 98d83e addc30 c2df23 d8e219 ece51b "
    "fde725"
)
BLUES = _anchors("f7fbff deebf7 c6dbef 9dcae1 6aaed6 4191c6 2070b4 08509b 08306b")  # Brewer 2003
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"


class ColourScale(NamedTuple):
    """Maps numbers from `low` to `high` to colours; numbers beyond the ends have the colour of the end."""

    low: float
    high: float
    colours: tuple[str, ...] = VIRIDIS
    is_log: bool = False
    is_stepped: bool = False  # each colour stands for one of as many equal parts of the range; none is blended

    def fractions(self, values: Any) -> np.ndarray:
        """Return numbers relative to both ends, 0 to 1; NaN where there is none."""
        values, low, high = np.asarray(values, float), self.low, self.high
        if self.is_log:
            with np.errstate(all="ignore"):
                values = np.log(np.where(values > 0.0, values, np.nan))
            low, high = float(np.log(low)), float(np.log(high))
        return np.clip((values - low) / ((high - low) or 1.0), 0.0, 1.0)

    def rgb(self, fractions: np.ndarray) -> np.ndarray:
        """Return the colours (..., 3), uint8, at fractions of the range; those of NaN are the first."""
        anchors = np.array([[int(colour[i : i + 2], 16) for i in (1, 3, 5)] for colour in self.colours], float)
        fractions = np.nan_to_num(fractions)
        if self.is_stepped:
            return anchors[np.minimum((fractions * len(anchors)).astype(int), len(anchors) - 1)].astype(np.uint8)
        places = np.linspace(0.0, 1.0, len(anchors))
        blended = [np.interp(fractions, places, anchors[:, channel]) for channel in range(3)]
        return np.rint(np.stack(blended, -1)).astype(np.uint8)

    def hex_colours(self, fractions: Any) -> list[str]:
        """Return the colours at fractions of the range, as '#rrggbb'."""
        rgb = self.rgb(np.atleast_1d(np.asarray(fractions, float)))
        return [f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in rgb.tolist()]


def png_address(pixels: np.ndarray) -> str:
    """Return an image (rows, columns, 4), uint8 RGBA, as the address of a PNG file within the text (RFC 2083)."""
    rows, columns, _ = pixels.shape
    lines = np.concatenate([np.zeros((rows, 1), np.uint8), pixels.reshape(rows, -1)], axis=1)  # filter type 0
    header = struct.pack(">IIBBBBB", columns, rows, 8, 6, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(lines.tobytes(), 9)), (b"IEND", b""))
    body = b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks
    )
    return "data:image/png;base64," + base64.b64encode(PNG_SIGNATURE + body).decode()
