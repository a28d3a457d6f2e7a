#include "codec/quad_nodal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "codec/bytes.h"
#include "multires/fvs_functionals.h"

namespace relief::codec {

using mesh::Index;
using mesh::Quadrangulation;
namespace fvs_mesh = multires::fvs_mesh;

namespace {

/// Of the largest number of its kind and level.
constexpr double kPrecision = 0x1p-24;

/// The step of one kind: a float, so that it is stored as it is.
float step_of(const std::vector<double>& numbers) {
    double largest = 0;
    for (const double number : numbers) largest = std::max(largest, std::abs(number));
    const auto step = static_cast<float>(std::min(largest * kPrecision, 0x1p120));
    return step > 0 ? step : 1.0F;
}

void quantise(std::vector<double>& numbers, ByteWriter& steps, std::vector<std::int64_t>& q) {
    const float step = step_of(numbers);
    steps.f32(step);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
        const double multiple = std::rint(numbers[k] / static_cast<double>(step));
        q[k] = static_cast<std::int64_t>(multiple);
        numbers[k] = multiple * static_cast<double>(step);
    }
}

/// False: the step is no step.
bool dequantise(const std::vector<std::int64_t>& q, float step, std::vector<double>& numbers) {
    for (std::size_t k = 0; k < q.size(); ++k)
        numbers[k] = static_cast<double>(q[k]) * static_cast<double>(step);
    return step > 0 && std::isfinite(step);
}

}  // namespace

QuadNodal::QuadNodal(const fvs_mesh::Hierarchy& hierarchy) : hierarchy_(hierarchy) {}

template <class Coder>
void QuadNodal::code_number(Coder& coder, std::int64_t& number, QuadNumber kind,
                            std::span<const Index> quads) {
    number = NumberCoder<Coder>(coder, model_)
                 .code(number, static_cast<std::uint32_t>(kind), sums_.around(quads),
                       below_.below(quads, sums_.size()));
    sums_.add(quads, number);
}

template <class Coder>
void QuadNodal::code_base(Coder& coder, Quantised& numbers) {
    const Quadrangulation& mesh = hierarchy_.mesh(0);
    const mesh::VertexQuads quads = vertex_quads(mesh);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        code_number(coder, numbers.value[v], QuadNumber::Value, quads.of(v));
        code_number(coder, numbers.dx[v], QuadNumber::Dx, quads.of(v));
        code_number(coder, numbers.dy[v], QuadNumber::Dy, quads.of(v));
    }
    const auto owners = mesh::edge_quads(mesh);
    for (Index e = 0; e < mesh.edge_count(); ++e)
        code_number(coder, numbers.normal[e], QuadNumber::Normal, owners[e]);
}

template <class Coder>
void QuadNodal::code_details(Coder& coder, QuantisedDetails& numbers) {
    const auto owners = mesh::edge_quads(parent());
    const Index edges = parent().edge_count();
    for (Index e = 0; e < edges; ++e) {
        code_number(coder, numbers.edge_value[e], QuadNumber::EdgeValue, owners[e]);
        code_number(coder, numbers.edge_tangential[e], QuadNumber::EdgeTangential, owners[e]);
        code_number(coder, numbers.normal[2 * e], QuadNumber::NewNormal, owners[e]);
        code_number(coder, numbers.normal[2 * e + 1], QuadNumber::NewNormal, owners[e]);
    }
    for (Index q = 0; q < parent().quad_count(); ++q) {
        const std::array<Index, 1> owner = {q};
        code_number(coder, numbers.centre_value[q], QuadNumber::CentreValue, owner);
        code_number(coder, numbers.centre_dx[q], QuadNumber::CentreDx, owner);
        code_number(coder, numbers.centre_dy[q], QuadNumber::CentreDy, owner);
        for (Index i = 0; i < 4; ++i)
            code_number(coder, numbers.normal[2 * edges + 4 * q + i], QuadNumber::NewNormal, owner);
    }
}

void QuadNodal::begin_level() {
    QuadSums sums(parent().quad_count());
    below_ = next_ == 0 ? sums : std::move(sums_);
    sums_ = std::move(sums);
}

Bytes QuadNodal::encode_next(fvs_mesh::Decomposition& coefficients) {
    begin_level();
    ByteWriter out;
    RangeEncoder coder;
    const auto quantise_kind = [&](std::vector<double>& numbers, std::vector<std::int64_t>& q) {
        quantise(numbers, out, q);
    };
    if (next_ == 0) {
        auto numbers = fvs_mesh::make_nodal<std::int64_t>(parent());
        fvs_mesh::for_each_nodal(quantise_kind, coefficients.base, numbers);
        code_base(coder, numbers);
    } else {
        auto numbers = fvs_mesh::make_details<std::int64_t>(parent());
        auto& details = coefficients.details[static_cast<std::size_t>(next_) - 1];
        fvs_mesh::for_each_detail(quantise_kind, details, numbers);
        code_details(coder, numbers);
    }
    ++next_;
    out.bytes(coder.finish());
    return out.take();
}

Status QuadNodal::decode_next(std::span<const std::uint8_t> bytes,
                              fvs_mesh::Decomposition& coefficients) {
    begin_level();
    ByteReader in(bytes);
    std::array<float, 6> steps{};
    for (std::size_t k = 0; k < (next_ == 0 ? 4U : 6U); ++k) steps[k] = in.f32();
    RangeDecoder coder(in.rest());
    bool good = true;
    std::size_t kind = 0;
    const auto dequantise_kind = [&](const std::vector<std::int64_t>& q,
                                     std::vector<double>& numbers) {
        good = dequantise(q, steps[kind++], numbers) && good;
    };
    if (next_ == 0) {
        auto numbers = fvs_mesh::make_nodal<std::int64_t>(parent());
        coefficients.base = fvs_mesh::make_nodal<double>(parent());
        code_base(coder, numbers);
        fvs_mesh::for_each_nodal(dequantise_kind, numbers, coefficients.base);
    } else {
        auto numbers = fvs_mesh::make_details<std::int64_t>(parent());
        auto& details = coefficients.details.emplace_back(fvs_mesh::make_details<double>(parent()));
        code_details(coder, numbers);
        fvs_mesh::for_each_detail(dequantise_kind, numbers, details);
    }
    if (!good || !coder.at_end())
        return Error{ErrorCode::BadFile, "the coefficients of a level are damaged",
                     "level " + std::to_string(next_) + " of the refinement"};
    ++next_;
    return {};
}

}  // namespace relief::codec
