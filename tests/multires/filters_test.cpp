#include "relief/multires/filters.h"

#include "support.h"

namespace relief::multires {
namespace {

using test::rational;
using test::reference;

void expect_sequence(const nlohmann::json& expected, const Sequence& actual,
                     const std::string& what) {
    EXPECT_EQ(expected.size(), actual.taps.size()) << what;
    for (const auto& [n, value] : expected.items())
        EXPECT_NEAR(rational(value), actual(std::stoi(n)), 1e-15) << what << " at " << n;
}

FilterBank bank_named(const std::string& name) {
    if (name.substr(0, 2) == "cw") return *filter_bank(name[2] - '0', Family::SemiOrthogonal, 0);
    return *filter_bank(name[3] - '0', Family::Compact, name[4] - '0');
}

TEST(Filters, MatchTheReferenceSequences) {
    const auto sequences = reference("barycentric.json")["seq1d"];
    for (const auto& [name, expected] : sequences.items()) {
        const FilterBank bank = bank_named(name);
        expect_sequence(expected["p"], bank.p, name + " p");
        expect_sequence(expected["q"], bank.q, name + " q");
        if (expected.contains("a")) expect_sequence(expected["a"], bank.a, name + " a");
        if (expected.contains("b")) expect_sequence(expected["b"], bank.b, name + " b");
        if (expected.contains("Na") && name != "cw1")
            expect_sequence(expected["Na"], bank.a, name + " Na");
        if (expected.contains("Nb") && name != "cw1")
            expect_sequence(expected["Nb"], bank.b, name + " Nb");
    }
}

TEST(Filters, PolesFactorTheSymbol) {
    const auto sequences = reference("barycentric.json")["seq1d"];
    for (const std::string name : {"cw2", "cw3", "cw4"}) {
        const FilterBank bank = bank_named(name);
        std::vector<double> product = {bank.gain};
        for (const double pole : bank.poles) {
            EXPECT_LT(std::abs(pole), 1);
            const double factor[] = {-pole, 1 + pole * pole, -pole};
            std::vector<double> next(product.size() + 2, 0.0);
            for (std::size_t i = 0; i < product.size(); ++i)
                for (std::size_t k = 0; k < 3; ++k) next[i + k] += product[i] * factor[k];
            product = next;
        }
        const int reach = static_cast<int>(product.size() / 2);
        EXPECT_EQ(product.size(), sequences[name]["D"].size());
        for (const auto& [k, value] : sequences[name]["D"].items())
            EXPECT_NEAR(rational(value), product[static_cast<std::size_t>(std::stoi(k) + reach)],
                        1e-14)
                << name;
    }
    EXPECT_NEAR(bank_named("cw2").poles[0], std::sqrt(3.0) - 2, 1e-15);
}

/// sum a(n) p(n + 2k) and so on are the identity: the finite pairs are biorthogonal.
TEST(Filters, CompactPairsAreBiorthogonal) {
    const int pairs[][2] = {{1, 1}, {1, 3}, {1, 5}, {2, 2}, {2, 4}, {3, 1}, {3, 3}, {4, 2}, {4, 4}};
    for (const auto& pair : pairs) {
        const FilterBank bank = *filter_bank(pair[0], Family::Compact, pair[1]);
        for (int k = -8; k <= 8; ++k) {
            double ap = 0, aq = 0, bp = 0, bq = 0;
            for (int n = -20; n <= 20; ++n) {
                ap += bank.a(n) * bank.p(n + 2 * k);
                aq += bank.a(n) * bank.q(n + 2 * k);
                bp += bank.b(n) * bank.p(n + 2 * k);
                bq += bank.b(n) * bank.q(n + 2 * k);
            }
            EXPECT_NEAR(ap, k == 0, 1e-15);
            EXPECT_NEAR(bq, k == 0, 1e-15);
            EXPECT_NEAR(aq, 0, 1e-15);
            EXPECT_NEAR(bp, 0, 1e-15);
        }
    }
}

TEST(Filters, KernelsMatchTheReference) {
    const auto kernels = reference("barycentric.json")["kernels"];
    for (const auto& [name, expected] : kernels.items())
        for (int c = 0; c < 8; ++c)
            for (const bool synthesis : {false, true}) {
                const auto& table = expected[synthesis ? "synthesis" : "analysis"];
                if (!table.contains(channel_name(c))) continue;
                const HexKernel kernel = synthesis ? synthesis_kernel(bank_named(name), c)
                                                   : analysis_kernel(bank_named(name), c);
                double missing = 0;
                for (const double tap : kernel.taps) missing += std::abs(tap);
                for (const auto& tap : table[channel_name(c)]) {
                    const double value = rational(tap[2]);
                    EXPECT_NEAR(value, kernel(tap[0].get<int>(), tap[1].get<int>()), 1e-15);
                    missing -= std::abs(value);
                }
                EXPECT_NEAR(missing, 0, 1e-12)
                    << name << ' ' << channel_name(c) << ": taps outside the table";
            }
}

TEST(Filters, UnknownPairsAreRefusedWithTheKnownOnes) {
    EXPECT_NE(filter_bank(2, Family::Compact, 3).error().message.find("2,2 2,4"),
              std::string::npos);
    EXPECT_EQ(filter_bank(5, Family::Compact, 0).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(filter_bank(3, Family::TruncatedLiteral, 0).error().code, ErrorCode::InvalidArgument);
}

}  // namespace
}  // namespace relief::multires
