"""A second decoder of closed-loop files: lattices of a tile, their margins, and the base. See reference_decoder.py."""

import os
import struct

from reference_bits import RangeDecoder, clamp

DOCS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../docs")


def f32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def float_bits(value):
    return struct.unpack("<I", struct.pack("<f", value))[0]


class Plane:
    """A level of a tile with its margins; missing elements are 0."""

    def __init__(self, rows, cols):
        self.rows, self.cols, self.cells = rows, cols, {}

    def __getitem__(self, place):
        return self.cells.get(place, 0)

    def __setitem__(self, place, value):
        self.cells[place] = value


class Level:
    def __init__(self, rows, cols, highest, valid, borders):
        self.rows, self.cols, self.highest = rows, cols, highest
        self.valid, self.borders = valid, borders  # borders: north, south, west, east
        self.values, self.quotients = Plane(rows, cols), Plane(rows, cols)


def continue_level(level):
    """Three samples beyond the sides where the raster ends."""
    north, south, west, east = level.borders
    v, rows, cols = level.values, level.rows, level.cols

    def reflected(border, inside):
        return clamp(2 * border - inside, -level.highest, 2 * level.highest)

    for r in range(-3, rows + 3):
        for k in (1, 2, 3):
            inside = min(k, cols - 1)
            if west:
                v[r, -k] = reflected(v[r, 0], v[r, inside])
            if east:
                v[r, cols - 1 + k] = reflected(v[r, cols - 1], v[r, cols - 1 - inside])
    for c in range(-3, cols + 3):
        for k in (1, 2, 3):
            inside = min(k, rows - 1)
            if north:
                v[-k, c] = reflected(v[0, c], v[inside, c])
            if south:
                v[rows - 1 + k, c] = reflected(v[rows - 1, c], v[rows - 1 - inside, c])


def fill_margins(level, reach, parity, neighbours):
    """Means of neighbours at the points of a parity up to `reach` outside."""
    for r in range(-reach, level.rows + reach):
        for c in range(-reach, level.cols + reach):
            outside = not (0 <= r < level.rows and 0 <= c < level.cols)
            if outside and parity(r, c):
                total = sum(level.values[r + i, c + j] for i, j in neighbours)
                level.values[r, c] = (total + 2) >> 2


def refined(coarse, rows, cols, valid):
    """The next level: EE samples, and the margins that they give."""
    continue_level(coarse)
    fine = Level(rows, cols, coarse.highest, valid, coarse.borders)
    for r in range(-4, rows + 4, 2):
        for c in range(-4, cols + 4, 2):
            fine.values[r, c] = coarse.values[r // 2, c // 2]
            if 0 <= r < rows and 0 <= c < cols:
                fine.quotients[r, c] = coarse.quotients[r // 2, c // 2]
    fill_margins(fine, 3, lambda r, c: r % 2 and c % 2, ((-1, -1), (-1, 1), (1, -1), (1, 1)))
    return fine


def fill_edge_margins(level):
    """When the D samples are there."""
    fill_margins(level, 2, lambda r, c: (r + c) % 2, ((-1, 0), (1, 0), (0, -1), (0, 1)))


def kept(q):
    return clamp(q, -30000, 30000)


def decode_base(level, data, step):
    coder = RangeDecoder(data)
    v, highest = level.values, level.highest
    for r in range(level.rows):
        for c in range(level.cols):
            if r and c:
                predicted = v[r, c - 1] + v[r - 1, c] - v[r - 1, c - 1]
            elif r or c:
                predicted = v[r, c - 1] if c else v[r - 1, c]
            else:
                predicted = highest // 2
            predicted = clamp(predicted, 0, highest)
            q = 0
            if level.valid[r][c]:
                length = 0
                while length < 32 and coder.bit(52000):
                    length += 1
                number = 1
                while length:
                    some = min(length, 16)
                    length -= some
                    number = number << some | coder.raw(some)
                q = number >> 1 if number & 1 else -(number >> 1)
            v[r, c] = clamp(predicted + q * step, -2**29, 2**30)
    coder.finish()
