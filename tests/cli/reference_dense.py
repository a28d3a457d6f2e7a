"""A second decoder of closed-loop files: "Profile dense". See reference_decoder.py."""

import math

from reference_bits import SQUASH, STRETCH, RangeDecoder, clamp, rate
from reference_levels import f32, fill_edge_margins, float_bits, kept


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


def miss(x):
    return math.floor(clamp(abs(x) - 1, 0, 16))


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
        self.scores = [[0, 0, 0] for _ in KINDS]
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
        other.scores = [list(scores) for scores in self.scores]
        other.candidates = self.candidates
        return other

    def decode(self, level, data, number, step, raw_bits):
        for estimate in self.estimates.values():
            estimate[1] = min(estimate[1], 10)
        for regression in self.regressions:
            regression.fade()
        level.misses = {}
        coder = RangeDecoder(data)
        for r in range(1, level.rows, 2):
            DenseRow(self, coder, level, number, step, raw_bits, 0, r).decode()
        fill_edge_margins(level)
        for r in range(level.rows):
            DenseRow(self, coder, level, number, step, raw_bits, 1 if r % 2 else 2, r).decode()
        coder.finish()

    def estimate(self, key):
        return self.estimates.setdefault(key, [2**21, 0])

    @staticmethod
    def update(estimate, bit):
        x, visits = estimate
        x += ((bit * (2**22 - 1) - x) * rate(visits)) >> 16
        estimate[:] = x, min(visits + 1, 1023)

    def mixed(self, coder, keys, mixer, refinement=None):
        estimates = [self.estimate(key) for key in keys]
        weights = self.mixers.setdefault(mixer, [5898] * 3)
        s = [STRETCH[x >> 10] for x, _ in estimates]
        y = clamp(sum(a * b for a, b in zip(weights, s)) >> 14, -3072, 3072)
        predicted = one = SQUASH[y + 3072]
        if refinement:
            cells = self.refinements.setdefault(refinement, SQUASH[::128])
            c = min((y + 3072) // 128, 47)
            f = y + 3072 - 128 * c
            one = (predicted + (cells[c] * (128 - f) + cells[c + 1] * f) // 128) // 2
        bit = coder.bit(clamp(one, 16, 65520))
        target = 65535 * bit
        for k in range(3):
            change = (s[k] * ((target - predicted) >> 2) + 2**15) >> 16
            weights[k] = clamp(weights[k] + change, -2**17, 2**17)
        if refinement:
            nearest = c if f < 64 else c + 1
            cells[nearest] += (target - cells[nearest]) >> 6
        for estimate in estimates:
            self.update(estimate, bit)
        return bit


class DenseRow:
    """The samples of one kind in one row."""

    def __init__(self, state, coder, level, number, step, raw_bits, kind, r):
        self.state, self.coder, self.level = state, coder, level
        self.number, self.kind, self.r = number, kind, r
        self.fine, self.raw_bits = step, raw_bits
        self.step = step = step << raw_bits
        self.rules = KINDS[kind]
        self.per_step = f32(1 / step)
        self.rules_apply = step == 1 and kind > 0
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
        about = {"E": octave(scale), "T": octave(steps), "signs": signs,
                 "M": 12 * sum_class(around >> 1) + sum_class(late + early)}
        rules, candidate = self.rules_at(c, n)
        holds = candidate is not None and self.state.scores[self.kind][candidate] > 0
        bias = (self.kind, higher, octave(scale) * 2 // 5, signs)
        mean, count = self.state.biases.get(bias, (0.0, 0))
        guess = p + (.8 * mean) * step
        if holds:
            guess, about["E"] = rules[candidate], candidate
        q, value = self.code(c, guess, second, about)

        echo = q == 0 and step > 1 and not self.raw_bits
        if not holds:
            error = 0.0 if echo else clamp(f32((value - guess) * (1 / step)), -10.0, 10.0)
            mean = f32(mean + f32(f32(error - mean) * f32(1 / (count + 4))))
            self.state.biases[bias] = mean, min(count + 1, 44)
        if self.rules_apply:
            self.learn_rules(c, value, rules, p, candidate)
        if self.teaches(c, q != 0 and step > 1 and scale < SCALE["surprising"]):
            weight = (1 / step) * (1 / step) / (scale * scale + 1)
            self.equations.append(self.equation(c, base, .3 * weight if echo else weight))

    def code(self, c, guess, second, about):
        """The quotient and the value."""
        level, step = self.level, self.fine
        bounded = clamp(guess, 0, level.highest)
        predicted = near(bounded)
        about["lost"] = f32(f32(bounded - predicted) * self.per_step)
        about["dispute"] = f32(f32(second - guess) * self.per_step)
        q = self.quotient(about)
        half = (step - 1) // 2
        steps = q
        if self.raw_bits:
            steps = (q << self.raw_bits) + self.coder.low_bits(self.raw_bits)
            steps -= 1 << self.raw_bits - 1
        value = clamp(predicted + steps * step, -half, level.highest + half)
        level.values[self.r, c], level.quotients[self.r, c] = value, kept(q)
        return q, value

    def rules_at(self, c, n):
        """What the rules predict, and which of them is the candidate."""
        if not self.rules_apply:
            return None, None
        row, col = self.rules["near"][1]
        values = [(n[0] + n[3]) / 2, (n[1] + n[2]) / 2,
                  2 * n[1] - self.level.values[self.r + 2 * row, c + 2 * col]]
        seen = [self.level.misses.get((self.r + i, c + j), (16,) * 4)
                for i, j in ((0, -2), (-2, -2), (-2, 0), (-2, 2))]
        if not any(misses[3] for misses in seen):
            return values, None
        good = [k for k in range(3) if not any(misses[k] for misses in seen)]
        return values, good[0] if good else None

    def learn_rules(self, c, value, rules, p, candidate):
        halves = [2 * (value - rules[0]), 2 * (value - rules[1]), value - rules[2], 2 * (value - p)]
        misses = tuple(miss(x) for x in halves)
        self.level.misses[self.r, c] = misses
        if candidate is not None:
            scores = self.state.scores[self.kind]
            gain = misses[3] - miss(2 * (value - rules[candidate]))
            scores[candidate] = clamp(scores[candidate] + gain, -256, 256)

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

        decide = self.state.mixed
        if not decide(coder, nodes(0, fraction), ("zero", kind, coarse), ("zero", kind, e)):
            return 0
        lean = fraction + 4 if fraction and lost < 0 else fraction
        distance = reached(about["dispute"], DISPUTE)
        dispute = 5 - distance if about["dispute"] < 0 else 5 + distance
        negative = decide(coder, (("lean", kind, signs, lean), ("sign scale", signs, e),
                                  ("dispute", lean, dispute)), ("sign", kind))
        agrees = fraction and bool(negative) == (lost < 0)
        lean = fraction + 4 if agrees else fraction
        bucket = 0
        while bucket < 61:
            node = min(bucket + 1, 15)
            if not decide(coder, nodes(node, lean), ("beyond", node, coarse)):
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
