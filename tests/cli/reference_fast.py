"""A second decoder of closed-loop files: "Profile fast". See reference_decoder.py."""

import os
import struct

from reference_bits import clamp
from reference_levels import DOCS, f32, fill_edge_margins, float_bits, kept


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

    def decode(self, level, data, _number, step, _raw_bits):
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
    fill_edge_margins(level)


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
