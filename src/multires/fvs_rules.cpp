#include "multires/fvs_rules.h"

#include <cmath>

#include "relief/spline/fvs_cell.h"

namespace relief::multires::fvs {

namespace {

using spline::FvsCellNumber;
using spline::kFvsCell;
using spline::kFvsCellNumbers;

/// The data in the middle of a cell's lower and left edge and of the cell, from its 16 numbers.
std::array<double, kDetailKinds> children(const std::array<double, kFvsCellNumbers>& n, double a,
                                          double b) {
    const double* f = n.data();
    const double* x = f + 4;
    const double* y = f + 8;
    const double bottom = n[12], right = n[13], top = n[14], left = n[15];
    const auto value = [](double f0, double f1, double length, double d0, double d1) {
        return (f0 + f1) / 2 + length / 8 * (d0 - d1);
    };
    const auto slope = [](double f0, double f1, double length, double d0, double d1) {
        return 3 * (f1 - f0) / (2 * length) - (d0 + d1) / 4;
    };
    const auto quarter = [](double near, double middle, double far) {
        return 3 * near / 8 + 3 * middle / 4 - far / 8;
    };
    const double q_bottom =
        (f[0] + f[1]) / 2 + a / 6 * (x[0] - x[1]) + b / 12 * (4 * bottom - y[0] - y[1]);
    const double q_right =
        (f[1] + f[2]) / 2 + b / 6 * (y[1] - y[2]) - a / 12 * (4 * right - x[1] - x[2]);
    const double q_top =
        (f[3] + f[2]) / 2 + a / 6 * (x[3] - x[2]) - b / 12 * (4 * top - y[3] - y[2]);
    const double q_left =
        (f[0] + f[3]) / 2 + b / 6 * (y[0] - y[3]) + a / 12 * (4 * left - x[0] - x[3]);
    const double bottom_slope = slope(f[0], f[1], a, x[0], x[1]);
    const double top_slope = slope(f[3], f[2], a, x[3], x[2]);
    const double left_slope = slope(f[0], f[3], b, y[0], y[3]);
    const double right_slope = slope(f[1], f[2], b, y[1], y[2]);
    const double cx = 3 * (q_right - q_left) / (2 * a);
    const double cy = 3 * (q_top - q_bottom) / (2 * b);
    std::array<double, kDetailKinds> out{};
    out[kEhv] = value(f[0], f[1], a, x[0], x[1]);
    out[kEht] = bottom_slope;
    out[kGh0a] = quarter(y[0], bottom, y[1]);
    out[kGh0b] = quarter(y[1], bottom, y[0]);
    out[kEvv] = value(f[0], f[3], b, y[0], y[3]);
    out[kEvt] = left_slope;
    out[kGv0a] = quarter(x[0], left, x[3]);
    out[kGv0b] = quarter(x[3], left, x[0]);
    out[kCv] = (q_bottom + q_right + q_top + q_left) / 4;
    out[kCx] = cx;
    out[kCy] = cy;
    out[kGh1a] = 3 * left_slope / 4 + a / (8 * b) * (x[3] - x[0]) + cy / 4;
    out[kGh1b] = 3 * right_slope / 4 - a / (8 * b) * (x[2] - x[1]) + cy / 4;
    out[kGv1a] = 3 * bottom_slope / 4 + b / (8 * a) * (y[1] - y[0]) + cx / 4;
    out[kGv1b] = 3 * top_slope / 4 - b / (8 * a) * (y[2] - y[3]) + cx / 4;
    return out;
}

/// A number of a block of cells of size 1, which a detail's update may change.
struct Number {
    int plane;
    int row;
    int col;
};

/// The one or two coarse cells that own a detail, with the cells around them.
struct Block {
    int rows = 1;
    int cols = 1;
    int above = 0;  ///< further rows and columns of cells that exist
    int below = 0;
    int left = 0;
    int right = 0;
};

std::vector<Number> numbers_of(const Block& block) {
    const FvsGrid<double> sizes(block.cols, block.rows);
    std::vector<Number> numbers;
    for (int p = 0; p < spline::kFvsPlanes; ++p)
        for (int r = 0; r < sizes[p].rows(); ++r)
            for (int c = 0; c < sizes[p].cols(); ++c) numbers.push_back({p, r, c});
    return numbers;
}

FvsGrid<double> zeros(std::int64_t nx, std::int64_t ny) {
    FvsGrid<double> grid(nx, ny, 1, 1);
    for (auto& plane : grid.planes) plane = Grid<double>(plane.rows(), plane.cols(), 0.0);
    return grid;
}

/// The integral of the product of two splines on cells of size 1/2, derivatives per unit.
double product(const FvsGrid<double>& u, const FvsGrid<double>& v) {
    const auto& mass = spline::fvs_cell_mass();
    const auto number = [](const FvsGrid<double>& grid, std::int64_t r, std::int64_t c,
                           std::size_t k) {
        const FvsCellNumber& at = kFvsCell[k];
        return grid[at.plane](r + at.row, c + at.col) * (at.plane == spline::kFvsF ? 1 : 0.5);
    };
    double sum = 0;
    for (std::int64_t r = 0; r < u.ny(); ++r)
        for (std::int64_t c = 0; c < u.nx(); ++c)
            for (std::size_t m = 0; m < kFvsCellNumbers; ++m)
                for (std::size_t n = 0; n < kFvsCellNumbers; ++n)
                    sum += number(u, r, c, m) * mass[m][n] * number(v, r, c, n);
    return sum / 4;
}

/// The mass matrix of the block's numbers, to which the cells around contribute.
Grid<double> block_mass(const Block& block, const std::vector<Number>& numbers) {
    const auto& mass = spline::fvs_cell_mass();
    const auto find = [&](const FvsCellNumber& at, int r, int c) {
        for (std::size_t k = 0; k < numbers.size(); ++k)
            if (numbers[k].plane == at.plane && numbers[k].row == r + at.row &&
                numbers[k].col == c + at.col)
                return static_cast<std::int64_t>(k);
        return std::int64_t{-1};
    };
    const auto size = static_cast<std::int64_t>(numbers.size());
    Grid<double> matrix(size, size, 0.0);
    for (int r = -block.above; r < block.rows + block.below; ++r)
        for (int c = -block.left; c < block.cols + block.right; ++c) {
            std::array<std::int64_t, kFvsCellNumbers> index{};
            for (std::size_t k = 0; k < kFvsCellNumbers; ++k) index[k] = find(kFvsCell[k], r, c);
            for (std::size_t m = 0; m < kFvsCellNumbers; ++m)
                for (std::size_t n = 0; n < kFvsCellNumbers; ++n)
                    if (index[m] >= 0 && index[n] >= 0) matrix(index[m], index[n]) += mass[m][n];
        }
    return matrix;
}

/// Solves matrix x = rhs by elimination of the symmetric positive definite matrix, in place.
void solve(Grid<double> matrix, std::vector<double>& x) {
    const std::int64_t n = matrix.rows();
    for (std::int64_t k = 0; k < n; ++k)
        for (std::int64_t r = k + 1; r < n; ++r) {
            const double factor = matrix(r, k) / matrix(k, k);
            for (std::int64_t c = k; c < n; ++c) matrix(r, c) -= factor * matrix(k, c);
            x[std::size_t(r)] -= factor * x[std::size_t(k)];
        }
    for (std::int64_t k = n - 1; k >= 0; --k) {
        for (std::int64_t c = k + 1; c < n; ++c)
            x[std::size_t(k)] -= matrix(k, c) * x[std::size_t(c)];
        x[std::size_t(k)] /= matrix(k, k);
    }
}

/// Basis functions of a block's numbers on the fine cells, and their products with those of the
/// details of an owner at (row, col) of the block.
class Projection {
  public:
    Projection(int rows, int cols, Owner owner, int row, int col)
        : rows_(rows), cols_(cols), row_(row), col_(col), numbers_(numbers_of({rows, cols})) {
        for (const Number& number : numbers_) {
            FvsGrid<double> coarse = zeros(cols, rows);
            coarse[number.plane](number.row, number.col) = 1;
            basis_.push_back(zeros(2 * cols, 2 * rows));
            basis_.back().a = basis_.back().b = 0.5;
            predict<double>(std::as_const(coarse).view(), basis_.back().view());
        }
        for (int kind = 0; kind < kDetailKinds; ++kind) {
            const DetailPlace& place = kDetailPlaces[std::size_t(kind)];
            if (place.owner != owner) continue;
            FvsGrid<double> fine = zeros(2 * cols, 2 * rows);
            fine[place.plane](2 * row + place.row, 2 * col + place.col) = 1;
            std::vector<double> products;
            for (const auto& function : basis_) products.push_back(product(function, fine));
            kinds_.push_back(kind);
            products_.push_back(std::move(products));
        }
    }

    /// Fills the updates of the owner's kinds for the cells that exist around the block.
    void fill(Block around, int row_class, int col_class, UpdateTaps& out) const {
        around.rows = rows_;
        around.cols = cols_;
        const Grid<double> mass = block_mass(around, numbers_);
        for (std::size_t k = 0; k < kinds_.size(); ++k) {
            std::vector<double> u = products_[k];
            solve(mass.clone(), u);
            Taps& taps =
                out.taps[std::size_t(kinds_[k])][std::size_t(row_class)][std::size_t(col_class)];
            for (std::size_t m = 0; m < numbers_.size(); ++m)
                taps.push_back(
                    {numbers_[m].plane, numbers_[m].row - row_, numbers_[m].col - col_, u[m]});
        }
    }

  private:
    int rows_;
    int cols_;
    int row_;
    int col_;
    std::vector<Number> numbers_;
    std::vector<FvsGrid<double>> basis_;
    std::vector<int> kinds_;
    std::vector<std::vector<double>> products_;
};

constexpr bool bit(int value, int mask) {
    return (value & mask) != 0;
}

/// Edge classes 1, 2 and 3 have a cell before, after, or both; bits 4 and 8 tell of cells behind
/// those.
bool possible_edge_class(int edge) {
    return (edge & 3) != 0 && (!bit(edge, 4) || bit(edge, 1)) && (!bit(edge, 8) || bit(edge, 2));
}

void fill_edges(Owner owner, UpdateTaps& out) {
    const bool horizontal = owner == Owner::HorizontalEdge;
    for (int sides = 1; sides <= 3; ++sides) {
        const int cells = sides == 3 ? 2 : 1;
        const int edge = bit(sides, 1) ? 1 : 0;
        const Projection projection = horizontal ? Projection(cells, 1, owner, edge, 0)
                                                 : Projection(1, cells, owner, 0, edge);
        for (int across = sides; across < kClasses; across += 4) {
            if (!possible_edge_class(across)) continue;
            const int before = bit(across, 4) ? 1 : 0, after = bit(across, 8) ? 1 : 0;
            for (int along = 0; along < 4; ++along) {
                const int first = along & 1, last = along >> 1;
                Block around;
                if (horizontal)
                    around = {0, 0, before, after, first, last};
                else
                    around = {0, 0, first, last, before, after};
                projection.fill(around, horizontal ? across : along, horizontal ? along : across,
                                out);
            }
        }
    }
}

UpdateTaps make_update_taps() {
    UpdateTaps out;
    fill_edges(Owner::HorizontalEdge, out);
    fill_edges(Owner::VerticalEdge, out);
    const Projection cell(1, 1, Owner::Cell, 0, 0);
    for (int rows = 0; rows < 4; ++rows)
        for (int cols = 0; cols < 4; ++cols)
            cell.fill({0, 0, rows & 1, rows >> 1, cols & 1, cols >> 1}, rows, cols, out);
    return out;
}

}  // namespace

std::array<Taps, kDetailKinds> prediction_taps(double a, double b) {
    std::array<Taps, kDetailKinds> taps;
    for (std::size_t k = 0; k < kFvsCellNumbers; ++k) {
        std::array<double, kFvsCellNumbers> unit{};
        unit[k] = 1;
        const auto weights = children(unit, a, b);
        for (std::size_t kind = 0; kind < kDetailKinds; ++kind)
            if (weights[kind] != 0)
                taps[kind].push_back(
                    {kFvsCell[k].plane, kFvsCell[k].row, kFvsCell[k].col, weights[kind]});
    }
    return taps;
}

const UpdateTaps& update_taps() {
    static const UpdateTaps table = make_update_taps();
    return table;
}

}  // namespace relief::multires::fvs
