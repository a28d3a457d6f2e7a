"""A second decoder of closed-loop files: bytes, the range coder, probabilities and masks. See reference_decoder.py."""

import struct


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
