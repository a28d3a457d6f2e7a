#include "relief/spline/box_spline.h"

#include <map>
#include <utility>

#include "spline/spline_testing.h"

namespace relief::spline {
namespace {

class BoxSplines : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Orders, BoxSplines, testing::Range(1, kMaxOrder + 1));

using Point = std::pair<int, int>;

/// The whole Bezier net of M_ddd: ordinate (a, b) belongs to the point (a, b) / degree.
std::map<Point, std::int64_t> whole_net(const BoxSpline& spline) {
    std::map<Point, std::int64_t> net;
    const int n = spline.degree;
    for (const ReachingControl& control : spline.reach) {
        std::size_t k = 0;
        for (int p = 0; p <= n; ++p) {
            for (int t = 0; t <= p; ++t, ++k) {
                const Point lower{p - control.i * n, t - control.j * n};
                for (const Point& at : {lower, Point{lower.second, lower.first}}) {
                    const auto [entry, is_new] = net.try_emplace(at, control.numerators[k]);
                    EXPECT_EQ(entry->second, control.numerators[k]) << "the net is not continuous";
                }
            }
        }
    }
    return net;
}

double fraction(const std::string& text) {
    const std::size_t slash = text.find('/');
    const double numerator = std::stod(text.substr(0, slash));
    return slash == std::string::npos ? numerator : numerator / std::stod(text.substr(slash + 1));
}

double weight_at(const std::vector<MaskTap>& mask, int i, int j) {
    for (const MaskTap& tap : mask)
        if (tap.i == i && tap.j == j) return tap.weight;
    return 0;
}

void expect_mask(const std::vector<MaskTap>& mask, const nlohmann::json& expected) {
    EXPECT_EQ(mask.size(), expected.size());
    for (const auto& entry : expected)
        // Some golden fractions are approximations, off by up to 8e-16.
        EXPECT_NEAR(weight_at(mask, entry[0], entry[1]), fraction(entry[2]), 1e-15) << entry;
}

TEST(BoxSpline, OrderTwoHasTheSpecifiedBezierNet) {
    const nlohmann::json table = golden()["bezier_order2"];
    const BoxSpline& spline = box_spline(2);
    EXPECT_EQ(spline.denominator, 24);
    ASSERT_EQ(spline.reach.size(), table["points"].size());
    for (const ReachingControl& control : spline.reach) {
        const std::string key = std::to_string(control.i) + "," + std::to_string(control.j);
        EXPECT_EQ(control.numerators, table["points"][key].get<std::vector<std::int64_t>>()) << key;
    }
}

TEST(BoxSpline, LatticeValuesAndGramMasksAreTheSpecified) {
    const nlohmann::json data = golden();
    for (const int d : {1, 2, 3})
        expect_mask(box_spline(d).samples, data["samples"][std::to_string(d)]);
    for (const int d : {1, 2}) expect_mask(box_spline(d).gram, data["gram"][std::to_string(d)]);
    EXPECT_DOUBLE_EQ(weight_at(box_spline(2).gram, 0, 0), 1979.0 / 7560);
    EXPECT_DOUBLE_EQ(weight_at(box_spline(2).gram, 1, 0), 18871.0 / 181440);
    EXPECT_DOUBLE_EQ(weight_at(box_spline(2).gram, 2, 1), 85.0 / 6048);
    EXPECT_DOUBLE_EQ(weight_at(box_spline(2).gram, 3, 3), 1.0 / 181440);
}

TEST(BoxSpline, GramOfAnOrderIsTheSampleMaskOfTwiceTheOrder) {
    for (const int d : {1, 2}) {
        const std::vector<MaskTap>& gram = box_spline(d).gram;
        const std::vector<MaskTap>& samples = box_spline(2 * d).samples;
        ASSERT_EQ(gram.size(), samples.size());
        for (std::size_t k = 0; k < gram.size(); ++k) {
            EXPECT_EQ(gram[k].i, samples[k].i);
            EXPECT_EQ(gram[k].j, samples[k].j);
            EXPECT_EQ(gram[k].weight, samples[k].weight);
        }
    }
}

TEST_P(BoxSplines, OrdinatesSumToTheDenominatorExactly) {
    const BoxSpline& spline = box_spline(GetParam());
    EXPECT_EQ(spline.degree, 3 * GetParam() - 2);
    for (int k = 0; k < ordinate_count(spline.degree); ++k) {
        std::int64_t sum = 0;
        for (const ReachingControl& control : spline.reach) sum += control.numerators[k];
        EXPECT_EQ(sum, spline.denominator);
    }
}

TEST_P(BoxSplines, NetHasTheSymmetriesOfTheHexagon) {
    const auto net = whole_net(box_spline(GetParam()));
    for (const auto& [at, ordinate] : net) {
        const auto [a, b] = at;
        // A turn by 60 degrees maps e1 to -e3 and e2 to -e1.
        const Point turned{a - b, a};
        const auto image = net.find(turned);
        EXPECT_EQ(image == net.end() ? 0 : image->second, ordinate) << a << ", " << b;
    }
}

/// Across the common edge p q of two triangles with apexes v and w = p + q - v, ordinates of w's
/// side at distance k <= 2d - 2 from the edge are alternating multinomial sums of those of v's
/// side: exactly, in integers.
TEST_P(BoxSplines, NetIsSmoothAcrossEveryEdgeExactly) {
    const int d = GetParam();
    const int n = box_spline(d).degree;
    const auto net = whole_net(box_spline(d));
    const auto ordinate = [&](int a, int b) {
        const auto entry = net.find({a, b});
        return entry == net.end() ? std::int64_t{0} : entry->second;
    };
    const auto factorial = [](int m) {
        return static_cast<std::int64_t>(std::llround(std::tgamma(m + 1.0)));
    };
    int rough_beyond = 0;
    const auto expect_smooth = [&](Point p, Point q, Point v) {
        const Point w{p.first + q.first - v.first, p.second + q.second - v.second};
        const auto at = [&](int np, int nq, int nv, int nw) {
            return ordinate(np * p.first + nq * q.first + nv * v.first + nw * w.first,
                            np * p.second + nq * q.second + nv * v.second + nw * w.second);
        };
        for (int k = 0; k <= 2 * d - 1; ++k) {
            for (int np = 0; np <= n - k; ++np) {
                const int nq = n - k - np;
                std::int64_t sum = 0;
                for (int a = 0; a <= k; ++a)
                    for (int b = 0; a + b <= k; ++b)
                        sum += factorial(k) / factorial(a) / factorial(b) / factorial(k - a - b) *
                               (b % 2 ? -1 : 1) * at(np + a, nq + (k - a - b), b, 0);
                if (k <= 2 * d - 2) {
                    EXPECT_EQ(at(np, nq, 0, k), sum) << "at distance " << k;
                }
                rough_beyond += k == 2 * d - 1 && at(np, nq, 0, k) != sum;
            }
        }
    };
    for (int i = -d; i < d; ++i) {
        for (int j = -d; j < d; ++j) {
            expect_smooth({i, j}, {i + 1, j + 1}, {i + 1, j});
            expect_smooth({i, j}, {i + 1, j}, {i + 1, j + 1});
            expect_smooth({i + 1, j}, {i + 1, j + 1}, {i, j});
        }
    }
    EXPECT_GT(rough_beyond, 0) << "smoother than a box spline can be: the test compares nothing";
}

TEST(BoxSpline, OrderOneIsTheHatFunction) {
    const auto hat = [](double x, double y) {
        return std::max(0.0, 1 - std::max({std::abs(x), std::abs(y), std::abs(x - y)}));
    };
    for (double x = -1.5; x < 1.6; x += 0.13)
        for (double y = -1.5; y < 1.6; y += 0.11)
            EXPECT_NEAR(box_spline_jet(1, x, y).value, hat(x, y), 1e-15);
}

TEST_P(BoxSplines, JetsOfTranslatesSumToOne) {
    const int d = GetParam();
    for (double x = 0; x < 1; x += 0.17) {
        for (double y = 0; y < 1; y += 0.13) {
            SurfaceJet<double> sum;
            for (int i = -d; i <= d; ++i) {
                for (int j = -d; j <= d; ++j) {
                    const SurfaceJet<double> jet = box_spline_jet(d, x - i, y - j);
                    sum.value += jet.value;
                    sum.di += jet.di;
                    sum.djj += jet.djj;
                }
            }
            // A sum of at most 48 rounded terms of size 1 (values), 10 (gradients) and 100
            // (Hessians).
            EXPECT_NEAR(sum.value, 1, 1e-14);
            EXPECT_NEAR(sum.di, 0, 1e-13);
            EXPECT_NEAR(sum.djj, 0, 1e-12);
        }
    }
}

TEST_P(BoxSplines, DerivativesAreDifferencesOfNeighbouringSplines) {
    const int d = GetParam();
    const double h = 1e-5;
    const auto value = [d](double x, double y) { return box_spline_jet(d, x, y).value; };
    for (double x = -1.9312; x < 2; x += 0.2917) {
        for (double y = -1.8743; y < 2; y += 0.2339) {
            const SurfaceJet<double> jet = box_spline_jet(d, x, y);
            // Truncation h^2 / 6 and rounding 1e-16 / h stay below 1e-10.
            EXPECT_NEAR(jet.di, (value(x + h, y) - value(x - h, y)) / (2 * h), 1e-9);
            EXPECT_NEAR(jet.dj, (value(x, y + h) - value(x, y - h)) / (2 * h), 1e-9);
            const double twist = box_spline_jet(d, x, y + h).di - box_spline_jet(d, x, y - h).di;
            const double bend = box_spline_jet(d, x + h, y).di - box_spline_jet(d, x - h, y).di;
            if (d == 1) continue;
            // Order 2 has third derivatives that jump: the difference is off by their jump times h.
            EXPECT_NEAR(jet.dij, twist / (2 * h), 1e-4);
            EXPECT_NEAR(jet.dii, bend / (2 * h), 1e-4);
        }
    }
}

TEST_P(BoxSplines, GramMaskIsTheIntegralOfProducts) {
    const int d = GetParam();
    const int m = 16;
    for (const auto& [i, j] : {Point{0, 0}, Point{1, 0}, Point{2, 1}, Point{-1, 1}}) {
        double sum = 0;
        for (int a = -d * m; a <= d * m; ++a)
            for (int b = -d * m; b <= d * m; ++b)
                sum += box_spline_jet(d, a / double(m), b / double(m)).value *
                       box_spline_jet(d, a / double(m) - i, b / double(m) - j).value;
        // The sum over points 1/16 apart errs by O(16^-2d): the first derivative that jumps is the
        // (2d-1)-th.
        EXPECT_NEAR(sum / (m * m), weight_at(box_spline(d).gram, i, j), std::pow(16, -2 * d));
    }
}

}  // namespace
}  // namespace relief::spline
