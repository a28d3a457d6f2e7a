#pragma once

#include "edit/plane_model.h"
#include "edit/triangle_moves.h"
#include "edit/triangle_spline.h"
#include "relief/codec/ps_codec.h"
#include "relief/mesh/triangle_locator.h"

namespace relief::edit {

/// A Powell-Sabin spline. One of three components is a surface in space; of two the first is shown
/// and moved.
class TriangleModel final : public PlaneModel {
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
        int level, mesh::Index vertex) const override;

  private:
    using Components = TriangleSpline::Components;

    TriangleModel(std::shared_ptr<const ByteSource> source, codec::PsFile file,
                  std::unique_ptr<multires::ps::Hierarchy> hierarchy,
                  std::vector<Components> original);
    [[nodiscard]] Description described() const;

    [[nodiscard]] std::size_t shown_components() const { return file_.components() == 3 ? 3 : 1; }
    [[nodiscard]] const multires::ps::Space& space(int level) const {
        return hierarchy_->space(hierarchy_->levels() - level);
    }
    [[nodiscard]] TriangleSpline shown(View::Show show, int level) const;

    std::shared_ptr<const ByteSource> source_;
    codec::PsFile file_;
    std::unique_ptr<multires::ps::Hierarchy> hierarchy_;
    std::vector<Components> original_;    ///< of each level
    std::vector<Components> compressed_;  ///< the same; empty: nothing was compressed
    std::vector<mesh::TriangleLocator> locators_;
    const TriangleMoves* moves_ = nullptr;  ///< owned by the base
};

}  // namespace relief::edit
