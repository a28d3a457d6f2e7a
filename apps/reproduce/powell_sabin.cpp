#include "powell_sabin.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "functions.h"
#include "relief/mesh/delaunay.h"
#include "relief/multires/ps_energy.h"
#include "relief/multires/ps_lift.h"

namespace relief::reproduce {

namespace ps_text {

using mesh::Index;
using ps::Update;

namespace {

constexpr const char* kSource = "powell-sabin (Vanraes, Windmolders, Bultheel, Dierckx)";

Eigen::VectorXd vector_of(const ps::Coefficients& spline) {
    return Eigen::Map<const Eigen::VectorXd>(spline.front().data(),
                                             static_cast<Eigen::Index>(3 * spline.size()));
}

/// The splines of the finest level that the details of a level stand for.
void append_wavelets(const ps::Hierarchy& hierarchy, int level, Update update,
                     std::vector<ps::Coefficients>& basis) {
    ps::Decomposition zero;
    zero.base.resize(hierarchy.space(0).mesh.x.size());
    for (int k = 0; k < hierarchy.levels(); ++k)
        zero.details.emplace_back(hierarchy.space(k + 1).mesh.x.size() -
                                  hierarchy.space(k).mesh.x.size());
    ps::Coefficients& numbers =
        level < 0 ? zero.base : zero.details[static_cast<std::size_t>(level)];
    for (ps::Heights& heights : numbers)
        for (double& height : heights) {
            height = 1;
            basis.push_back(*synthesise(hierarchy, zero, hierarchy.levels(), update));
            height = 0;
        }
}

/// The largest mean of a wavelet, that of the B-spline which it lifts being 1.
double largest_mean(const ps::Hierarchy& hierarchy, Update update) {
    const ps::Space& fine = hierarchy.space(1);
    const auto masses = ps::moments(fine, ps::gram_matrix(fine));
    const std::size_t old = hierarchy.space(0).mesh.x.size();
    std::vector<ps::Coefficients> wavelets;
    append_wavelets(hierarchy, 0, update, wavelets);
    double largest = 0;
    for (std::size_t k = 0; k < wavelets.size(); ++k) {
        double mean = 0;
        for (std::size_t v = 0; v < masses.size(); ++v)
            for (std::size_t j = 0; j < 3; ++j) mean += wavelets[k][v][j] * masses[v][j].mass;
        largest = std::max(largest, std::abs(mean) / masses[old + k / 3][k % 3].mass);
    }
    return largest;
}

/// Analysis and synthesis undo each other.
double reconstruction_error(const ps::Space& base, Update update) {
    const ps::Hierarchy hierarchy = *ps::Hierarchy::create(base, 2);
    const ps::Coefficients finest = franke_spline(hierarchy.space(2));
    const ps::Decomposition parts = *analyse(hierarchy, finest, update);
    const ps::Coefficients back = *synthesise(hierarchy, parts, 2, update);
    double error = 0;
    for (std::size_t v = 0; v < back.size(); ++v)
        for (std::size_t j = 0; j < 3; ++j)
            error = std::max(error, std::abs(back[v][j] - finest[v][j]));
    return error;
}

}  // namespace

ps::Space squares(int side) {
    std::vector<Vec2> vertices;
    std::vector<std::array<Index, 3>> triangles;
    const auto number = [side](int row, int col) {
        return static_cast<Index>(row * (side + 1) + col);
    };
    for (int row = 0; row <= side; ++row)
        for (int col = 0; col <= side; ++col)
            vertices.push_back({static_cast<double>(col) / side, static_cast<double>(row) / side});
    for (int row = 0; row < side; ++row)
        for (int col = 0; col < side; ++col) {
            const Index a = number(row, col);
            const Index c = number(row + 1, col + 1);
            triangles.push_back({a, number(row, col + 1), c});
            triangles.push_back({a, c, number(row + 1, col)});
        }
    return *ps::make_space(*mesh::build(vertices, triangles));
}

ps::Space random_space(int sites, unsigned seed) {
    std::mt19937 engine(seed);
    const auto draw = [&engine] { return 0x1p-32 * engine(); };
    std::vector<Vec2> places{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    while (static_cast<int>(places.size()) < sites) {
        const double x = draw();
        places.push_back({x, draw()});
    }
    return *ps::make_space(mesh::delaunay(places, {.peel = 0.01})->mesh);
}

ps::Coefficients franke_spline(const ps::Space& space) {
    ps::TangentPlanes planes;
    for (Index v = 0; v < space.mesh.vertex_count(); ++v) {
        const spline::PlaneJet jet = franke(space.mesh.origin + space.mesh.vertex(v));
        planes.push_back({jet.value, jet.gradient});
    }
    return ps::coefficients(space, planes);
}

std::vector<ps::Coefficients> all_b_splines(const ps::Space& space) {
    ps::Coefficients one(space.mesh.x.size());
    std::vector<ps::Coefficients> all;
    for (ps::Heights& heights : one)
        for (double& height : heights) {
            height = 1;
            all.push_back(one);
            height = 0;
        }
    return all;
}

double scaled_condition(const ps::Space& space, const std::vector<ps::Coefficients>& splines) {
    const ps::BlockMatrix gram = ps::gram_matrix(space);
    const auto count = static_cast<Eigen::Index>(splines.size());
    const auto length = static_cast<Eigen::Index>(3 * space.mesh.x.size());
    Eigen::MatrixXd basis(length, count);
    Eigen::MatrixXd image(length, count);
    for (Eigen::Index k = 0; k < count; ++k) {
        const ps::Coefficients& spline = splines[static_cast<std::size_t>(k)];
        basis.col(k) = vector_of(spline);
        image.col(k) = vector_of(gram.times(spline));
    }
    Eigen::MatrixXd products = basis.transpose() * image;
    const Eigen::VectorXd scale = products.diagonal().cwiseSqrt().cwiseInverse();
    products = scale.asDiagonal() * products * scale.asDiagonal();
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(products, Eigen::EigenvaluesOnly)
            .eigenvalues();
    return values[count - 1] / values[0];
}

void add_wavelets(Rows& rows) {
    constexpr std::pair<Update, const char*> kUpdates[] = {{Update::None, "none"},
                                                           {Update::Moments, "moments"},
                                                           {Update::Semi, "semi"},
                                                           {Update::Semi2, "semi2"},
                                                           {Update::Semi2Moments, "semi2, moments"},
                                                           {Update::Full, "full"}};
    for (const auto& [update, name] : kUpdates)
        for (const int levels : {1, 2}) {
            const ps::Hierarchy hierarchy = *ps::Hierarchy::create(squares(1), levels);
            std::vector<ps::Coefficients> basis;
            for (int level = -1; level < levels; ++level)
                append_wavelets(hierarchy, level, update, basis);
            rows.add("section 4, two triangles",
                     fmt::format("condition of {} level{}, update {}", levels,
                                 levels == 1 ? "" : "s", name),
                     {}, scaled_condition(hierarchy.space(levels), basis),
                     "all functions of norm 1");
        }
    const ps::Space base = random_space(14, 3);
    const ps::Hierarchy hierarchy = *ps::Hierarchy::create(base, 1);
    for (const auto& [update, name] : kUpdates) {
        rows.add("section 4, 14 vertices",
                 fmt::format("largest mean of a wavelet, update {}", name), {},
                 largest_mean(hierarchy, update), "of its B-spline: 1");
        rows.add("section 4, 14 vertices", fmt::format("reconstruction error, update {}", name), 0,
                 reconstruction_error(base, update), "two levels, values up to 1");
    }
}

}  // namespace ps_text

std::vector<Row> powell_sabin_rows() {
    Rows rows(ps_text::kSource);
    ps_text::add_refinement(rows);
    ps_text::add_wavelets(rows);
    return std::move(rows).take();
}

}  // namespace relief::reproduce
