#pragma once

#include "edit/plane_model.h"
#include "edit/quad_moves.h"
#include "relief/codec/quad_codec.h"

namespace relief::edit {

/// A C1 cubic spline on quads.
class QuadModel final : public PlaneModel {
  public:
    [[nodiscard]] static Result<std::unique_ptr<Model>> open(
        std::shared_ptr<const ByteSource> source);

    [[nodiscard]] Status check(const PointMove& move) const override;
    [[nodiscard]] Result<Bytes> file() const override;
    [[nodiscard]] Result<Compression> compress(double max_error, const Progress& progress) override;

  protected:
    [[nodiscard]] std::unique_ptr<LevelSpline> spline(View::Show show, int level) const override;
    [[nodiscard]] std::optional<CellPlace> locate(int level, Vec2 point,
                                                  Outside outside) const override;
    [[nodiscard]] std::optional<std::array<Vec3<double>, 3>> corners(
        int /*level*/, mesh::Index /*vertex*/) const override {
        return std::nullopt;
    }

  private:
    using Hierarchy = multires::fvs_mesh::Hierarchy;
    using Data = multires::fvs_mesh::NodalData;

    /// `original`: of each level, from the finest; `numbers`: what commands call the vertices of
    /// the finest.
    QuadModel(std::shared_ptr<const ByteSource> source, codec::QuadFile file,
              std::unique_ptr<Hierarchy> hierarchy, std::vector<Data> original,
              std::vector<mesh::Index> numbers);
    [[nodiscard]] Description described() const;

    [[nodiscard]] int refined(int level) const { return hierarchy_->levels() - level; }

    std::shared_ptr<const ByteSource> source_;
    codec::QuadFile file_;
    std::unique_ptr<Hierarchy> hierarchy_;
    std::vector<Data> original_;
    std::vector<Data> compressed_;      ///< the same; empty: nothing was compressed
    const QuadMoves* moves_ = nullptr;  ///< owned by the base
};

}  // namespace relief::edit
