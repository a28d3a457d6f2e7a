#pragma once

#include <memory>
#include <string>
#include <vector>

#include "codec/edits.h"
#include "codec/raster_header.h"
#include "relief/codec/container.h"
#include "relief/codec/raster_codec.h"

/// How the samples of a raster file are kept: what RasterFile asks, for each kind of file once.
namespace relief::codec {

/// Samples of a window, before moves.
struct BodySamples {
    multires::Planes<double> planes;  ///< not yet stored, if not `stored`
    bool stored = false;
    Grid<std::uint8_t> mask;  ///< empty: all valid
    double bound = 0;         ///< largest error; infinite: not known
    std::vector<LatticeBox> damaged = {};
};

class RasterBody {
  public:
    RasterBody() = default;
    RasterBody(const RasterBody&) = delete;
    RasterBody& operator=(const RasterBody&) = delete;
    virtual ~RasterBody() = default;

    /// Requires: a level of the file, a window inside its raster.
    [[nodiscard]] virtual Result<BodySamples> samples(int level,
                                                      const LatticeBox& window) const = 0;
    /// Those in `part`, and perhaps others, before moves.
    [[nodiscard]] virtual Result<ControlPart> coefficients(int level,
                                                           const LatticeBox& part) const = 0;
    /// Control coefficients of a surface through all samples, corrections included.
    [[nodiscard]] virtual Result<multires::Planes<double>> control_net() const = 0;

    /// Windows are decoded at the cost of what they depend on.
    [[nodiscard]] virtual bool decodes_parts() const = 0;
    [[nodiscard]] virtual int finest_level() const = 0;
    /// Bounds as those of RasterFile; infinite: not known.
    [[nodiscard]] virtual double bound(int level) const = 0;
    [[nodiscard]] virtual double surface_bound(int level) const = 0;
    [[nodiscard]] virtual std::uint64_t bytes_for(int level) const = 0;
    [[nodiscard]] virtual std::vector<double> band_steps() const = 0;
    [[nodiscard]] virtual std::vector<ChunkSummary> chunks() const = 0;
};

/// header and container must outlive the body. Errors: BadFile.
[[nodiscard]] Result<std::unique_ptr<RasterBody>> open_pyramid_body(
    const ContainerReader& container, const RasterHeader& header,
    const multires::PyramidLayout& layout);
[[nodiscard]] Result<std::unique_ptr<RasterBody>> open_lattice_body(
    const ContainerReader& container, const RasterHeader& header,
    const multires::PyramidLayout& layout);

}  // namespace relief::codec
