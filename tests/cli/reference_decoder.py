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

DOCS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../docs")


class Bytes:
    """Numbers from a byte string, in order."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, count):
        assert self.at + count <= len(self.data), "bytes are missing"
        self.at += count
        return self.data[self.at - count:self.at]

    def number(self, form):
        return struct.unpack("<" + form, self.take(struct.calcsize(form)))[0]

    def varint(self):
        value = shift = 0
        while True:
            byte = self.number("B")
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    def at_end(self):
        return self.at == len(self.data)


# Container


def library(name):
    return ctypes.CDLL(ctypes.util.find_library(name))


def checksum(data):
    xxh3 = library("xxhash").XXH3_64bits
    xxh3.restype = ctypes.c_uint64
    return xxh3(data, ctypes.c_size_t(len(data)))


def unpacked(packed, size):
    with open(os.path.join(DOCS, "header-dictionary.txt"), "rb") as file:
        dictionary = file.read()
    zstd = library("zstd")
    zstd.ZSTD_createDCtx.restype = context_type = ctypes.c_void_p
    decompress = zstd.ZSTD_decompress_usingDict
    decompress.restype = size_t = ctypes.c_size_t
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
    assert (file.number("H"), file.number("I")) == (1, 0)
    packed, size, directory_bytes = (file.number(form) for form in "IIQ")
    header = json.loads(unpacked(file.take(packed), size))
    directory = Bytes(file.take(directory_bytes))
    assert checksum(data[:file.at]) == file.number("Q")
    chunks, bounds = [], []
    for _ in range(directory.varint()):
        length = directory.varint()
        bounds.append(struct.unpack("<f", b"\0\0" + directory.take(2))[0])
        chunks.append(file.take(length))
        if length:
            assert checksum(chunks[-1]) & 0xFFFFFFFF == directory.number("I")
    assert directory.at_end() and file.at_end()
    return header, chunks, bounds


# Range coder and probabilities


class RangeDecoder:
    def __init__(self, data):
        self.data, self.loaded, self.range, self.offset = data, 0, 2**64 - 1, 0
        self.load()
        self.load()

    def load(self):
        word = self.data[self.loaded:self.loaded + 4].ljust(4, b"\0")
        self.offset = (self.offset << 32 | int.from_bytes(word, "big")) & (2**64 - 1)
        self.loaded += 4

    def renormalise(self):
        if self.range < 2**32:
            self.range <<= 32
            self.load()

    def bit(self, one):
        cut = (self.range >> 16) * one
        bit = self.offset < cut
        if bit:
            self.range = cut
        else:
            self.offset -= cut
            self.range -= cut
        self.renormalise()
        return int(bit)

    def raw(self, count):
        self.range >>= count
        value = min(self.offset // self.range, 2**count - 1)
        self.offset -= value * self.range
        self.renormalise()
        return value

    def low_bits(self, count):
        high = self.raw(count - 16) << 16 if count > 16 else 0
        return high | self.raw(min(count, 16)) if count else 0

    def finish(self):
        assert self.loaded - 8 <= len(self.data) <= self.loaded - 4, "the chunk has another length"


KNOTS = [32768, 36843, 40793, 44511, 47911, 50941, 53581, 55834, 57724, 59287, 60565, 61598, 62428,
         63090, 63615, 64030, 64357, 64614, 64816, 64974, 65097, 65194, 65269, 65328, 65374, 65410,
         65438, 65459, 65476, 65489, 65500, 65508, 65514, 65519, 65523, 65526, 65528, 65530, 65531,
         65532, 65533, 65534, 65534, 65535, 65535, 65535, 65535, 65535, 65535]


def squash(x):
    if x < 0:
        return 65536 - squash(-x)
    k = min(x // 64, 47)
    f = x - 64 * k
    return (KNOTS[k] * (64 - f) + KNOTS[k + 1] * f + 32) // 64


SQUASH = [squash(x) for x in range(-3072, 3073)]
STRETCH = []
for p in range(4096):
    x = STRETCH[-1] if STRETCH else -3072
    while x < 3072 and SQUASH[x + 3072] < 16 * p + 8:
        x += 1
    STRETCH.append(x)


def rate(visits):
    return min(655360 // (10 * visits + 16), 32767)


def clamp(value, low, high):
    return max(low, min(value, high))


class Slot:
    def __init__(self):
        self.slow, self.fast, self.visits = 2**31, 2**15, 0

    def decode(self, coder):
        bit = coder.bit(clamp(((self.slow >> 16) + self.fast) // 2, 16, 65520))
        self.slow += ((bit * (2**32 - 1) - self.slow) * rate(self.visits)) >> 16
        self.fast += ((bit * 65535 - self.fast) * rate(min(self.visits, 30))) >> 16
        self.visits = min(self.visits + 1, 1023)
        return bit


def decode_mask(data, rows, cols):
    coder = RangeDecoder(data)
    repeats = [Slot(), Slot()]
    slots = [Slot() for _ in range(1024)]
    image = []
    repeated = 1

    def pixel(i, j):
        inside = 0 <= i < len(image) and 0 <= j < cols
        return image[i][j] if inside and j < len(image[i]) else 1

    for i in range(rows):
        repeated = repeats[repeated].decode(coder)
        if repeated:
            image.append(list(image[-1]) if image else [1] * cols)
            continue
        image.append([])
        for j in range(cols):
            context = 0
            for di, dj in ((0, -2), (0, -1), (-1, -2), (-1, -1), (-1, 0), (-1, 1), (-1, 2),
                           (-2, -1), (-2, 0), (-2, 1)):
                context = 2 * context + pixel(i + di, j + dj)
            image[i].append(slots[context].decode(coder))
    coder.finish()
    return image


# Levels


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


def refined(coarse, rows, cols, valid):
    """The next level: EE samples, and all margins."""
    continue_level(coarse)
    fine = Level(rows, cols, coarse.highest, valid, coarse.borders)
    v = fine.values
    for r in range(-4, rows + 4, 2):
        for c in range(-4, cols + 4, 2):
            v[r, c] = coarse.values[r // 2, c // 2]
            if 0 <= r < rows and 0 <= c < cols:
                fine.quotients[r, c] = coarse.quotients[r // 2, c // 2]

    def fill(reach, parity, neighbours):
        for r in range(-reach, rows + reach):
            for c in range(-reach, cols + reach):
                outside = not (0 <= r < rows and 0 <= c < cols)
                if outside and parity(r, c):
                    v[r, c] = (sum(v[r + i, c + j] for i, j in neighbours) + 2) >> 2

    fill(3, lambda r, c: r % 2 and c % 2, ((-1, -1), (-1, 1), (1, -1), (1, 1)))
    fill(2, lambda r, c: (r + c) % 2, ((-1, 0), (1, 0), (0, -1), (0, 1)))
    return fine


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


# Profile dense


def f32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def float_bits(value):
    return struct.unpack("<I", struct.pack("<f", value))[0]


def octave(value):
    return clamp((float_bits(value) >> 21) - 487, 0, 39)


def near(value):
    return math.floor(value + 1073741824.5) - 2**30


CROSS = [(-1, -1), (-1, 1), (-2, 0)]
KINDS = [
    {"near": [(-1, -1), (-1, 1), (1, -1), (1, 1)],
     "features": [[(0, -2)], [(-1, -1)], [(-1, 1)], [(1, -1)], [(-2, -2)], [(-1, -3)], [(-1, 3)],
                  [(1, -3)], [(1, 3)], [(-3, -1)], [(-3, 1)], [(3, -1)], [(3, 1)], [(-2, 0)],
                  [(-2, 2)], [(-3, -3), (3, 3)]],
     "weights": [.06, .04, .04, 0, -.04, -.035, -.035, -.05, -.035, .02, -.025, -.03, -.04, -.08, 0,
                 0],
     "ring": [(-1, -3), (-1, 3), (1, -3), (1, 3), (-3, -1), (-3, 1), (3, -1), (3, 1)],
     "second": -1 / 25.6, "texture": .075,
     "causal": [(-2, 0), (-2, -2), (-2, 2)], "shares": [2, 1, 1], "west": 2,
     "signs": [(0, -2), (-2, 0)], "late": (0, 3), "early": (1, 2)},
    {"near": [(-1, 0), (0, -1), (0, 1), (1, 0)],
     "features": [[(0, -2)], [(-1, 0)], [(0, -1)], [(1, 0)], [(-2, -2)], [(-3, 0)], [(3, 0)],
                  [(0, -3)], [(0, 3)], [(-1, -1)], [(-1, 1)], [(-2, 0)], [(-2, -1), (-2, 1)],
                  [(2, -1), (2, 1)], [(-1, -2), (-1, 2)], [(1, -2), (1, 2)]],
     "weights": [-.08, -.1, .05, -.13, 0, .01, .005, .01, -.01, 0, 0, -.06, -.005, -.035, -.035,
                 -.03],
     "ring": [(-3, 0), (3, 0), (0, -3), (0, 3)], "second": -.05, "texture": .05,
     "causal": CROSS, "shares": [2, 2, 1], "west": 1,
     "signs": CROSS[:2], "late": (1, 2), "early": (0, 3)},
    {"near": [(0, -1), (-1, 0), (1, 0), (0, 1)],
     "features": [[(0, -2)], [(0, -1)], [(-1, 0)], [(0, 1)], [(-2, -2)], [(0, -3)], [(0, 3)],
                  [(-3, 0)], [(3, 0)], [(-1, -1)], [(-1, 1)], [(-2, 0)], [(-1, -2), (1, -2)],
                  [(-1, 2), (1, 2)], [(-2, -1), (2, -1)], [(-2, 1), (2, 1)]],
     "weights": [-.08, .15, .03, .09, 0, .01, 0, .015, .005, 0, 0, -.04, -.018, -.035, -.035, -.03],
     "ring": [(0, -3), (0, 3), (-3, 0), (3, 0)], "second": -.05, "texture": .05,
     "causal": CROSS, "shares": [2, 2, 1], "west": 1,
     "signs": CROSS[:2], "late": (1, 2), "early": (0, 3)},
]
LOST = [f32(x) for x in (.04, .12, .22, .34)]
DISPUTE = [f32(x) for x in (.05, .15, .35, .8, 2)]
SCALE = {name: f32(value) for name, value in
         {"around": .05, "late": .045, "early": .004, "texture": .09, "gap": .07, "least": .08,
          "surprising": .7}.items()}


def sum_class(x):
    for end, c in ((5, x), (6, 5), (9, 6), (13, 7), (19, 8), (28, 9), (43, 10)):
        if x <= end:
            return c
    return 11


def reached(x, limits):
    return sum(abs(x) >= limit for limit in limits)


class Regression:
    """What weights of one kind have learnt."""

    def __init__(self, start):
        self.start, self.weights, self.equations = start, list(start), 0
        self.matrix = [[0.0] * 16 for _ in range(16)]
        self.right = [0.0] * 16

    def fade(self):
        self.matrix = [[.3 * x for x in row] for row in self.matrix]
        self.right = [.3 * x for x in self.right]

    def learn(self, equations):
        for features, weight, target in equations:
            for j in range(16):
                weighted = weight * features[j]
                row = self.matrix[j]
                for k in range(j + 1):
                    row[k] += weighted * features[k]
                self.right[j] += (weight * target) * features[j]
        self.equations += len(equations)
        if self.equations >= 64:
            self.equations = 0
            self.solve()

    def solve(self):
        trace = 0.0
        for j in range(16):
            trace += self.matrix[j][j]
        ridge = .001 * trace / 16 + 200
        lower = [[0.0] * 16 for _ in range(16)]
        y = [0.0] * 16
        for j in range(16):
            for k in range(j + 1):
                m = self.matrix[j][k] + (ridge if j == k else 0)
                for i in range(k):
                    m -= lower[j][i] * lower[k][i]
                lower[j][k] = math.sqrt(max(m, 1e-12)) if j == k else m / lower[k][k]
            m = self.right[j] + ridge * self.start[j]
            for i in range(j):
                m -= lower[j][i] * y[i]
            y[j] = m / lower[j][j]
        for j in reversed(range(16)):
            m = y[j]
            for k in range(j + 1, 16):
                m -= lower[k][j] * y[k]
            y[j] = m / lower[j][j]
        self.weights = y


class Dense:
    """What the dense profile has learnt of one component."""

    def __init__(self):
        self.estimates, self.mixers, self.refinements, self.biases = {}, {}, {}, {}
        self.regressions = [Regression(kind["weights"]) for kind in KINDS]
        self.candidates = 0

    def descendant(self):
        other = Dense()
        other.estimates = {key: list(value) for key, value in self.estimates.items()}
        other.mixers = {key: list(value) for key, value in self.mixers.items()}
        other.refinements = {key: list(value) for key, value in self.refinements.items()}
        other.biases = dict(self.biases)
        for mine, its in zip(self.regressions, other.regressions):
            its.weights, its.equations = list(mine.weights), mine.equations
            its.matrix, its.right = [list(row) for row in mine.matrix], list(mine.right)
        other.candidates = self.candidates
        return other

    def decode(self, level, data, number, step):
        for estimate in self.estimates.values():
            estimate[1] = min(estimate[1], 16)
        for regression in self.regressions:
            regression.fade()
        coder = RangeDecoder(data)
        for r in range(1, level.rows, 2):
            DenseRow(self, coder, level, number, step, 0, r).decode()
        for r in range(level.rows):
            DenseRow(self, coder, level, number, step, 1 if r % 2 else 2, r).decode()
        coder.finish()

    def estimate(self, key):
        return self.estimates.setdefault(key, [2**21, 0])

    @staticmethod
    def update(estimate, bit):
        x, visits = estimate
        x += ((bit * (2**22 - 1) - x) * rate(visits)) >> 16
        estimate[:] = x, min(visits + 1, 1023)

    def mixed(self, coder, keys, mixer, refinement):
        estimates = [self.estimate(key) for key in keys]
        weights = self.mixers.setdefault(mixer, [5898] * 3)
        cells = self.refinements.setdefault(refinement, SQUASH[::128])
        s = [STRETCH[x >> 10] for x, _ in estimates]
        y = clamp(sum(a * b for a, b in zip(weights, s)) >> 14, -3072, 3072)
        predicted = SQUASH[y + 3072]
        c = min((y + 3072) // 128, 47)
        f = y + 3072 - 128 * c
        corrected = (cells[c] * (128 - f) + cells[c + 1] * f) // 128
        bit = coder.bit(clamp((predicted + corrected) // 2, 16, 65520))
        target = 65535 * bit
        for k in range(3):
            weights[k] += (s[k] * ((target - predicted) >> 3) + 2**15) >> 16
        nearest = c if f < 64 else c + 1
        cells[nearest] += (target - cells[nearest]) >> 6
        for estimate in estimates:
            self.update(estimate, bit)
        return bit


class DenseRow:
    """The samples of one kind in one row."""

    def __init__(self, state, coder, level, number, step, kind, r):
        self.state, self.coder, self.level = state, coder, level
        self.number, self.step, self.kind, self.r = number, step, kind, r
        self.rules = KINDS[kind]
        self.per_step = f32(1 / step)
        self.equations = []

    def decode(self):
        regression = self.state.regressions[self.kind]
        self.weights = regression.weights
        for c in range(0 if self.kind == 1 else 1, self.level.cols, 2):
            self.sample(c)
        regression.learn(self.equations)

    def at(self, plane, offset, c):
        return plane[self.r + offset[0], c + offset[1]]

    def predict(self, c):
        """The prediction, the base and the second opinion."""
        rules, w = self.rules, self.weights
        nearest = [self.at(self.level.values, n, c) for n in rules["near"]]
        share = 1 - w[0]
        for j in range(1, 16):
            for _ in rules["features"][j]:
                share -= w[j]
        line = 0.0
        for n in nearest:
            line += (share / 4) * n
        for j in range(1, 16):
            for place in rules["features"][j]:
                line += w[j] * self.at(self.level.values, place, c)
        p = line + w[0] * self.level.values[self.r, c - 2]
        share = 1 - rules["second"] * len(rules["ring"])
        second = 0.0
        for n in nearest:
            second += (share / 4) * n
        for place in rules["ring"]:
            second += rules["second"] * self.at(self.level.values, place, c)
        return p, sum(nearest) / 4, second, nearest

    def sample(self, c):
        level, r, step, rules = self.level, self.r, self.step, self.rules
        p, base, second, n = self.predict(c)
        if not level.valid[r][c]:
            level.values[r, c] = near(clamp(p, 0, level.highest))
            return
        size = [abs(self.at(level.quotients, place, c)) for place in rules["near"]]
        rough = (.25 * abs(n[0] - n[1] - n[2] + n[3]) +
                 .05 * (abs(n[0] - n[3]) + abs(n[1] - n[2])) +
                 rules["texture"] / abs(rules["second"]) * abs(second - base))
        steps = f32(f32(rough) * self.per_step)
        late = sum(size[k] for k in rules["late"])
        early = sum(size[k] for k in rules["early"])
        calm = f32(f32(f32(f32(SCALE["late"] * late) + f32(SCALE["early"] * early)) +
                       f32(SCALE["texture"] * steps)) + SCALE["least"])
        around = sum(share * abs(self.at(level.quotients, place, c))
                     for share, place in zip(rules["shares"], rules["causal"]))
        around += rules["west"] * abs(level.quotients[r, c - 2])
        gap = abs(f32(f32(second - p) * self.per_step))
        scale = f32(f32(calm + f32(SCALE["around"] * around)) + f32(SCALE["gap"] * gap))
        higher = sum((n[k] > p) << (3 - k) for k in range(4))
        signs = [self.at(level.quotients, place, c) for place in rules["signs"]]
        signs = sum(m * (1 + (q > 0) - (q < 0)) for m, q in zip((1, 3), signs))

        bias = (self.kind, higher, octave(scale) * 2 // 5, signs)
        mean, count = self.state.biases.get(bias, (0.0, 0))
        p += (.8 * mean) * step
        bounded = clamp(p, 0, level.highest)
        predicted = near(bounded)
        about = {"E": octave(scale), "T": octave(steps), "signs": signs,
                 "M": 12 * sum_class(around >> 1) + sum_class(late + early),
                 "lost": f32(f32(bounded - predicted) * self.per_step),
                 "dispute": f32(f32(second - p) * self.per_step)}
        q = self.quotient(about)
        half = (step - 1) // 2
        value = clamp(predicted + q * step, -half, level.highest + half)
        level.values[r, c], level.quotients[r, c] = value, kept(q)

        echo = q == 0 and step > 1
        error = 0.0 if echo else clamp(f32((value - p) * (1 / step)), -10.0, 10.0)
        mean = f32(mean + f32(f32(error - mean) * f32(1 / (count + 4))))
        self.state.biases[bias] = mean, min(count + 1, 44)
        if self.teaches(c, q != 0 and step > 1 and scale < SCALE["surprising"]):
            weight = (1 / step) * (1 / step) / (scale * scale + 1)
            self.equations.append(self.equation(c, base, .3 * weight if echo else weight))

    def teaches(self, c, surprising):
        if self.r < 2 or c < 2 or c + 1 >= self.level.cols:
            return False
        if surprising or self.number >= 3:
            return True
        self.state.candidates += 1
        return self.state.candidates % 4 == 0

    def equation(self, c, base, weight):
        features = []
        for places in self.rules["features"]:
            f = self.at(self.level.values, places[0], c) - base
            if len(places) == 2:
                f += self.at(self.level.values, places[1], c) - base
            features.append(f)
        return features, weight, self.level.values[self.r, c] - base

    def quotient(self, about):
        coder, kind, exact = self.coder, self.kind, self.step == 1
        e, m, t, signs, lost = (about[name] for name in ("E", "M", "T", "signs", "lost"))
        coarse = e * 2 // 5
        fraction = reached(lost, LOST)

        def nodes(node, lean):
            texture = ("texture", kind, t // 2, e // 2, node)
            if exact and node < 3:
                return ("exact scale", kind, e, lean, node), ("exact sums", kind, m, lean, node), texture
            return ("scale", kind, e, node), ("sums", kind, m, node), texture

        def decide(keys, mixer, refinement):
            return self.state.mixed(coder, keys, mixer, refinement)

        if not decide(nodes(0, fraction), ("zero", kind, coarse), ("zero", kind, e)):
            return 0
        lean = fraction + 4 if fraction and lost < 0 else fraction
        distance = reached(about["dispute"], DISPUTE)
        dispute = 5 - distance if about["dispute"] < 0 else 5 + distance
        negative = decide((("lean", kind, signs, lean), ("sign scale", signs, e),
                           ("dispute", lean, dispute)), ("sign", kind), ("sign", lean))
        agrees = fraction and bool(negative) == (lost < 0)
        lean = fraction + 4 if agrees else fraction
        bucket = 0
        while bucket < 61:
            node = min(bucket + 1, 15)
            if not decide(nodes(node, lean), ("beyond", node, coarse), ("beyond", node, coarse)):
                break
            bucket += 1
        magnitude = 1 + (bucket if bucket < 4 else self.place(bucket))
        return -magnitude if negative else magnitude

    def place(self, bucket):
        raw = bucket // 2 - 2
        estimate = self.state.estimate(("place", bucket))
        upper = self.coder.bit(clamp(estimate[0] >> 10 << 4, 16, 65520))
        self.state.update(estimate, upper)
        return ((2 + bucket % 2) << raw + 1) + (upper << raw) + self.coder.low_bits(raw)


# Profile fast


def first_tokens():
    with open(os.path.join(DOCS, "fast-tokens.txt"), encoding="ascii") as file:
        return [[int(weight) for weight in line.split()] for line in file]


def token_ranges():
    """The first magnitude of each token, and its bits beside the sign."""
    ranges = []
    for t in range(32):
        bits = 0 if t < 5 else 1 + (t - 5) // 2
        ranges.append((sum(2**b for _, b in ranges), bits))
    ranges[31] = ranges[31][0], 30
    return ranges


class Bits:
    def __init__(self, data):
        self.data, self.at = data, 0

    def get(self, count):
        value = int.from_bytes(self.data[self.at // 8:(self.at + count + 7) // 8], "little")
        value = value >> self.at % 8 & (1 << count) - 1
        self.at += count
        return value

    def whole_bytes(self):
        """How many bytes are begun; what is left of the last must be 0."""
        assert self.get(-self.at % 8) == 0
        return self.at // 8

    def signed(self):
        zeros = 0
        while self.get(1) == 0:
            zeros += 1
            assert zeros <= 7
        u = (1 << zeros) + self.get(zeros) - 1
        return -(u + 1) // 2 if u % 2 else u // 2


def frequencies(weights):
    parts = [((256, 304, 362, 431)[w % 4] << w // 4) if w else 0 for w in weights]
    f = [max(part * 4096 // sum(parts), 1) if part else 0 for part in parts]
    f[f.index(max(f))] += 4096 - sum(f)
    return f


class Fast:
    """What the fast profile has learnt of one component."""

    RANGES = token_ranges()

    def __init__(self, weights=None):
        self.weights = weights or first_tokens()

    def descendant(self):
        return Fast([list(row) for row in self.weights])

    def adapt(self, bits):
        if bits.get(1):
            self.weights = first_tokens()
        if not bits.get(1):
            return
        for row in self.weights:
            if not bits.get(1):
                continue
            last = max(t for t in range(32) if row[t]) + bits.signed()
            for t in range(32):
                row[t] = row[t] + bits.signed() if t <= last else 0
                assert 0 <= row[t] < 64
            assert any(row)

    def decode(self, level, data, _number, step):
        if not data:
            fill(level, step)
            return
        head = Bits(data)
        self.adapt(head)
        count = 2**head.get(2)
        words_end = 2 * head.get(head.get(5))
        begin = head.whole_bytes()
        words = iter(struct.unpack(f"<{words_end // 2}H", data[begin:begin + words_end]))
        rest = Bits(data[begin + words_end:])
        states = []
        for _ in range(count):
            low = next(words)
            states.append(low | next(words) << 16)
        tables = [frequencies(row) for row in self.weights]

        def token(c, j):
            x = states[j % count]
            slot, first, t = x & 4095, 0, 0
            while slot >= first + tables[c][t]:
                first += tables[c][t]
                t += 1
            x = tables[c][t] * (x >> 12) + slot - first
            states[j % count] = x << 16 | next(words) if x < 2**16 else x
            return t

        def quotients(classes):
            found = []
            for t in [0 if c is None else token(c, j) for j, c in enumerate(classes)]:
                first, bits = self.RANGES[t]
                sign = rest.get(1) if t else 0
                magnitude = first + rest.get(bits)
                found.append(-magnitude if sign else magnitude)
            return found

        decode_rows(level, step, quotients)
        assert next(words, None) is None and all(x == 2**16 for x in states)
        assert rest.whole_bytes() == len(rest.data)


def decode_rows(level, step, quotients):
    """quotients(classes): those of a row; the class of a hole is None."""
    v, highest = level.values, level.highest
    for place, value in v.cells.items():
        v[place] = clamp(value, -highest, 2 * highest)
    for i in range((level.rows + 1) // 2 + 1):
        for r in (2 * i + 1, 2 * i - 2, 2 * i - 1):
            diagonal = r == 2 * i + 1
            if not 0 <= r < level.rows:
                continue
            columns = range(0 if r % 2 and not diagonal else 1, level.cols, 2)
            known = [predict(level, step, diagonal, r, c) for c in columns]
            classes = [of if level.valid[r][c] else None for c, (_, of) in zip(columns, known)]
            for c, (p, _), q in zip(columns, known, quotients(classes)):
                value = (p + q * step + 2**31) % 2**32 - 2**31
                v[r, c] = clamp(value, -highest, 2 * highest)
                level.quotients[r, c] = kept(q)


def fill(level, step):
    decode_rows(level, step, lambda classes: [0] * len(classes))


FAST = {
    True: ([(-1, -1), (1, 1), (-1, 1), (1, -1)],
           [(-1, -3), (-1, 3), (1, -3), (1, 3), (-3, -1), (-3, 1), (3, -1), (3, 1)],
           [(-2, 0), (-2, 2)]),
    False: ([(-1, 0), (1, 0), (0, -1), (0, 1)],
            [(-2, -1), (-2, 1), (2, -1), (2, 1), (-1, -2), (-1, 2), (1, -2), (1, 2)],
            [(-1, -1), (-1, 1)]),
}


def predict(level, step, diagonal, r, c):
    """The prediction and the class of a sample."""
    near_places, far_places, earlier = FAST[diagonal]
    a, b, d, e = (level.values[r + i, c + j] for i, j in near_places)
    s = a + b + d + e
    x = sum(level.values[r + i, c + j] for i, j in far_places)
    p = clamp((10 * s - x + 16) >> 5, 0, level.highest)
    texture = abs(a + b - d - e) + (abs(2 * s - x) >> 2) + ((abs(a - b) + abs(d - e)) >> 2)
    around = (sum(min(abs(level.quotients[r + i, c + j]), 40) for i, j in near_places) +
              2 * sum(min(abs(level.quotients[r + i, c + j]), 40) for i, j in earlier))
    size = f32(f32(f32(min(texture, 2**30)) * f32(f32(.88) / step)) + around)
    return p, clamp((float_bits(size) >> 22) - 254, 0, 23)


# Tiles


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
        self.tiers = [Tier(0, self.header["rows"], self.header["cols"])]
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
                tile.coders[c].decode(level, data, number, step)
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
        rows, cols = self.header["rows"], self.header["cols"]
        planes = []
        for c, domain in enumerate(self.lattice["domains"]):
            plane = [[None] * cols for _ in range(rows)]
            for tile in tiles.values():
                for r, k in itertools.product(range(tile.box[2]), range(tile.box[3])):
                    if not tile.valid[r][k]:
                        continue
                    value = self.stored(domain["unit"] *
                                        (domain.get("origin", 0) + tile.levels[c].values[r, k]))
                    plane[tile.box[0] + r][tile.box[1] + k] = tile.repairs.get((c, r, k), value)
            planes.append(plane)
        return planes

    def stored(self, value):
        nodata = self.header.get("nodata")
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


f32_largest = struct.unpack("<f", b"\xff\xff\x7f\x7f")[0]


def main():
    with open(sys.argv[1], "rb") as file:
        planes = Decoder(file.read()).decode()
    print(len(planes[0]), len(planes[0][0]))
    for row in planes[0]:
        print(*("-" if value is None else value for value in row))


if __name__ == "__main__":
    main()
