"""A second decoder of closed-loop files, written from docs/format.md alone: plain Python, slow, and so short that it can
be read beside that page. It reads whole files without edits; anything unexpected fails an assertion.

usage: reference_decoder.py FILE    prints rows, columns and the samples of the first component
"""

import ctypes
import ctypes.util
import itertools
import json
import math
import os
import struct
import sys

from reference_bits import Bytes, clamp, decode_mask
from reference_dense import Dense
from reference_fast import Fast, fill
from reference_levels import DOCS, Level, decode_base, f32, refined


def library(name):
    return ctypes.CDLL(ctypes.util.find_library(name))


def checksum(data):
    xxh3 = library("xxhash").XXH3_64bits
    xxh3.restype = ctypes.c_uint64
    return xxh3(data, ctypes.c_size_t(len(data)))


def unpacked(packed):
    """The text of a Zstandard frame without its magic number."""
    with open(os.path.join(DOCS, "header-dictionary.txt"), "rb") as file:
        dictionary = file.read()
    packed = b"\x28\xb5\x2f\xfd" + packed
    zstd = library("zstd")
    size_t = ctypes.c_size_t
    content_size = zstd.ZSTD_getFrameContentSize
    content_size.restype = ctypes.c_uint64
    size = content_size(packed, size_t(len(packed)))
    assert size <= 2**24
    zstd.ZSTD_createDCtx.restype = context_type = ctypes.c_void_p
    decompress = zstd.ZSTD_decompress_usingDict
    decompress.restype = size_t
    text = ctypes.create_string_buffer(size)
    context = context_type(zstd.ZSTD_createDCtx())
    written = decompress(context, text, size_t(size), packed, size_t(len(packed)), dictionary,
                         size_t(len(dictionary)))
    zstd.ZSTD_freeDCtx(context)
    assert written == size
    return text.raw.decode()


def open_container(data):
    """The header, and the chunks with what the directory says of their errors."""
    file = Bytes(data)
    assert file.take(10) == b"RELIEF\x89\r\n\x1a"
    assert file.number("H") == 1
    packed, directory_bytes = file.varint(), file.varint()
    header = json.loads(unpacked(file.take(packed)))
    directory = Bytes(file.take(directory_bytes))
    assert checksum(data[:file.at]) & 0xFFFFFFFF == file.number("I")
    chunks, bounds = [], []
    bound = math.inf
    while not directory.at_end():
        length, new_bound = divmod(directory.varint(), 2)
        if new_bound:
            bound = struct.unpack("<f", b"\0\0" + directory.take(2))[0]
        bounds.append(bound)
        chunks.append(file.take(length))
        if length:
            assert checksum(chunks[-1]) & 0xFFFFFFFF == directory.number("I")
    assert file.at_end()
    return header, chunks, bounds


def up(n, level):
    """ceil(n / 2^level)"""
    return -(-n >> level)


class Tier:
    def __init__(self, k, rows, cols):
        self.k, self.rows, self.cols = k, rows, cols
        self.down, self.across = (max(1, (n + 256) // 512) for n in (rows, cols))

    def tile_of(self, row, col):
        return min(row // 512, self.down - 1), min(col // 512, self.across - 1)

    def box(self, tile):
        """row, column, rows, columns"""
        box = []
        for index, count, n in ((tile[0], self.down, self.rows), (tile[1], self.across, self.cols)):
            end = n if index == count - 1 else 512 * (index + 1)
            box += [512 * index, end - 512 * index]
        return box[0], box[2], box[1], box[3]

    def tiles(self):
        """Along the Hilbert curve."""
        bits = (max(self.down, self.across) - 1).bit_length()

        def index(tile):
            row, col = tile
            place = 0
            for bit in reversed(range(bits)):
                x, y = col >> bit & 1, row >> bit & 1
                place = 4 * place + ((3 * x) ^ y)
                if y == 0:
                    if x == 1:
                        row, col = row ^ (1 << bit) - 1, col ^ (1 << bit) - 1
                    row, col = col & (1 << bit) - 1, row & (1 << bit) - 1
            return place

        return sorted(itertools.product(range(self.down), range(self.across)), key=index)


class Tile:
    """A tile that is being decoded: a level, a coder and repairs for each component."""

    def __init__(self, box, borders, valid):
        self.box, self.borders, self.valid = box, borders, valid
        self.levels, self.coders, self.repairs = [], [], {}

    def has_samples(self):
        return any(any(row) for row in self.valid)


class Decoder:
    FORMS = {"uint8": "B", "uint16": "H", "int16": "h", "uint32": "I", "int32": "i",
             "float32": "f", "float64": "d"}

    def __init__(self, data):
        self.header, chunks, self.bounds = open_container(data)
        self.lattice = self.header["lattice"]
        assert self.header["content"] == "raster" and chunks[0] == b"", "edits are not read"
        self.chunks = chunks[1:]
        self.form = self.FORMS[self.header["type"]]
        self.margin = self.lattice.get("margin", [0, 0])
        self.tiers = [Tier(0, self.header["rows"] + self.margin[0],
                           self.header["cols"] + self.margin[1])]
        while self.tiers[-1].down * self.tiers[-1].across > 1:
            last = self.tiers[-1]
            self.tiers.append(Tier(last.k + 1, up(last.rows, 3), up(last.cols, 3)))
        top = self.tiers[-1]
        self.levels = 3 * top.k + max(0, (max(top.rows, top.cols) - 1).bit_length() - 1)

    def step(self, component, level):
        factor = 1.0
        for _ in range(level):
            if factor < 4:
                factor *= self.lattice.get("tightening", 1)
        step = self.lattice["domains"][component].get("step", 1) / min(factor, 4)
        return 2 * math.floor((step - 1) / 2 + 1 / 2) + 1

    def ranges(self, tier):
        """First and last level of each chunk of a tile."""
        if tier is not self.tiers[-1]:
            return [(level, level) for level in (3 * tier.k + 2, 3 * tier.k + 1, 3 * tier.k)]
        last = min(self.levels, 3 * tier.k + 4)
        return [(self.levels, last)] + [(level, level) for level in range(last - 1, 3 * tier.k - 1, -1)]

    def decode(self):
        """Planes of samples; None in holes."""
        above, next_chunk = None, iter(self.chunks)
        for tier in reversed(self.tiers):
            order, ranges = tier.tiles(), self.ranges(tier)
            chunks = {tile: [] for tile in order}
            for _ in ranges:
                for tile in order:
                    chunks[tile].append(Bytes(next(next_chunk)))
            decoded = {tile: self.tile(tier, tile, list(zip(ranges, chunks[tile])), above)
                       for tile in order}
            above = tier, decoded
        assert next(next_chunk, None) is None
        return self.planes(above[1])

    def tile(self, tier, number, chunks, above):
        box = tier.box(number)
        borders = (box[0] == 0, box[0] + box[2] == tier.rows, box[1] == 0,
                   box[1] + box[3] == tier.cols)
        tile = Tile(box, borders, self.mask(chunks[0][1], box))
        if above:
            self.begin(tile, number, tier, *above)
        if above and not tile.has_samples():
            for c in range(len(self.lattice["domains"])):
                for level in (3 * tier.k + 2, 3 * tier.k + 1, 3 * tier.k):
                    tile.levels[c] = self.next_level(tile, tier, c, level)
                    fill(tile.levels[c], 1)
            chunks[1:] = []
        else:
            for (first, last), chunk in chunks:
                for level in range(first, last - 1, -1):
                    self.level(tile, tier, level, chunk)
        assert all(chunk.at_end() for _, chunk in chunks)
        return tile

    @staticmethod
    def mask(chunk, box):
        form = chunk.number("B")
        assert form < 3
        if form == 2:
            return decode_mask(chunk.take(chunk.varint()), box[2], box[3])
        return [[1 - form] * box[3] for _ in range(box[2])]

    def begin(self, tile, number, tier, above, decoded):
        """What the tier above gives: samples, repairs, and what its coders have learnt."""
        row0, col0, rows, cols = tile.box
        parent = decoded[above.tile_of(row0 // 8, col0 // 8)]
        for c, domain in enumerate(self.lattice["domains"]):
            level = Level(up(rows, 3), up(cols, 3), domain["highest"], None, tile.borders)
            for r in range(-3, level.rows + 3):
                for k in range(-3, level.cols + 3):
                    row, col = row0 // 8 + r, col0 // 8 + k
                    if not (0 <= row < above.rows and 0 <= col < above.cols):
                        continue
                    source = decoded[above.tile_of(row, col)]
                    place = row - source.box[0], col - source.box[1]
                    level.values[r, k] = source.levels[c].values[place]
                    if 0 <= r < level.rows and 0 <= k < level.cols and (c, *place) in source.repairs:
                        tile.repairs[c, 8 * r, 8 * k] = source.repairs[c, place[0], place[1]]
            tile.levels.append(level)
            tile.coders.append(parent.coders[c].descendant())

    def next_level(self, tile, tier, component, level):
        shift = level - 3 * tier.k
        rows, cols = up(tile.box[2], shift), up(tile.box[3], shift)
        valid = [[tile.valid[r << shift][c << shift] for c in range(cols)] for r in range(rows)]
        if component < len(tile.levels):
            return refined(tile.levels[component], rows, cols, valid)
        return Level(rows, cols, self.lattice["domains"][component]["highest"], valid, tile.borders)

    def level(self, tile, tier, number, chunk):
        components = len(self.lattice["domains"])
        for c in range(components):
            data = chunk.take(chunk.varint())
            level, step = self.next_level(tile, tier, c, number), self.step(c, number)
            if number == self.levels:
                decode_base(level, data, step)
                tile.levels.append(level)
                tile.coders.append(Dense() if self.lattice["profile"] == "dense" else Fast())
            else:
                raw_bits = self.lattice["domains"][c].get("raw_bits", 0)
                tile.coders[c].decode(level, data, number, step, raw_bits)
                tile.levels[c] = level
        shift = number - 3 * tier.k
        rows, cols = up(tile.box[2], shift), up(tile.box[3], shift)
        index = 0
        for _ in range(chunk.varint()):
            index += chunk.varint()
            c, place = divmod(index, rows * cols)
            r, k = divmod(place, cols)
            tile.repairs[c, r << shift, k << shift] = chunk.number(self.form)
            index += 1

    def planes(self, tiles):
        rows, cols = self.tiers[0].rows, self.tiers[0].cols
        planes = []
        for c, domain in enumerate(self.lattice["domains"]):
            plane = [[None] * cols for _ in range(rows)]
            for tile in tiles.values():
                for r, k in itertools.product(range(tile.box[2]), range(tile.box[3])):
                    if not tile.valid[r][k]:
                        continue
                    number = domain.get("origin", 0) + tile.levels[c].values[r, k]
                    value = self.stored(float_number(number) if domain.get("floats")
                                        else domain["unit"] * number)
                    plane[tile.box[0] + r][tile.box[1] + k] = tile.repairs.get((c, r, k), value)
            planes.append([row[self.margin[1]:] for row in plane[self.margin[0]:]])
        return planes

    def stored(self, value):
        nodata = self.header.get("nodata")
        nodata = None if nodata is None else float(nodata)
        if self.form in "fd":
            largest = f32_largest if self.form == "f" else sys.float_info.max
            rounded = clamp(value, -largest, largest)
            rounded = f32(rounded) if self.form == "f" else rounded
            return rounded if nodata is None else self.beside_float(value, rounded, nodata)
        bits = 8 * struct.calcsize(self.form)
        low, high = (0, 2**bits - 1) if self.form.isupper() else (-2**(bits - 1), 2**(bits - 1) - 1)
        rounded = round(clamp(value, low, high))
        if nodata != rounded:
            return rounded
        upwards = rounded < high and (value >= rounded or rounded == low)
        return rounded + 1 if upwards else rounded - 1

    def beside_float(self, value, rounded, nodata):
        to_type = f32 if self.form == "f" else float
        tolerance = 2.0**-23
        a, b = rounded, to_type(nodata)
        difference, total = abs(to_type(a - b)), abs(to_type(a + b))
        if a != b and not difference < to_type(to_type(tolerance * total) * 2):
            return rounded
        if nodata == 0:
            smallest = 2.0**-126 if self.form == "f" else sys.float_info.min
            return math.copysign(smallest, value)
        largest = f32_largest if self.form == "f" else sys.float_info.max
        move = 8 * tolerance * abs(nodata)
        upwards = nodata + move <= largest and (value >= nodata or nodata - move < -largest)
        return to_type(nodata + move if upwards else nodata - move)


def float_number(n):
    """The n-th float: 0 is number 0, -0 number -1."""
    n = clamp(n, -0x7f800000, 0x7f7fffff)
    return struct.unpack("<f", struct.pack("<I", n if n >= 0 else 0x80000000 | ~n))[0]


f32_largest = struct.unpack("<f", b"\xff\xff\x7f\x7f")[0]


def main():
    with open(sys.argv[1], "rb") as file:
        planes = Decoder(file.read()).decode()
    print(len(planes[0]), len(planes[0][0]))
    for row in planes[0]:
        print(*("-" if value is None else value for value in row))


if __name__ == "__main__":
    main()
