"""Pixels of 8-bit PNG files, for cases that look at pictures. Standard library only."""

import pathlib
import struct
import zlib


def read_png(path):
    """(width, height, rows): each row a bytes object of R, G, B."""
    data = pathlib.Path(path).read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", path
    at, packed, header = 8, b"", None
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        at += 12 + size
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
    width, height, depth, colour, _, _, interlaced = header
    assert depth == 8 and colour in (2, 6) and not interlaced, header
    channels = 3 if colour == 2 else 4
    raw, rows, before = zlib.decompress(packed), [], bytearray(width * channels)
    for y in range(height):
        begin = y * (width * channels + 1)
        row = bytearray(raw[begin + 1:begin + 1 + width * channels])
        unfilter(raw[begin], row, before, channels)
        rows.append(bytes(row) if channels == 3 else bytes(b for i, b in enumerate(row) if i % 4 != 3))
        before = row
    return width, height, rows


def unfilter(kind, row, above, step):
    for i in range(len(row)):
        left, up = (row[i - step] if i >= step else 0), above[i]
        corner = above[i - step] if i >= step else 0
        if kind == 1:
            row[i] = (row[i] + left) & 255
        elif kind == 2:
            row[i] = (row[i] + up) & 255
        elif kind == 3:
            row[i] = (row[i] + (left + up) // 2) & 255
        elif kind == 4:
            p = left + up - corner
            nearest = min((left, up, corner), key=lambda v: abs(p - v))
            row[i] = (row[i] + nearest) & 255


def difference(a, b):
    """Mean of |a - b| over all bytes of two pictures' rows."""
    total = sum(abs(p - q) for row_a, row_b in zip(a, b) for p, q in zip(row_a, row_b))
    return total / sum(len(row) for row in a)
