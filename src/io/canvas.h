#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "io/colour.h"
#include "relief/io/image.h"

namespace relief::io::detail {

/// A projected point: pixels right and down, and nearness (larger is nearer; linear along straight
/// lines).
struct ScreenPoint {
    double x, y, nearness;
};

/// What a line looks like.
struct Pen {
    Srgb colour = {};
    double opacity = 1;
    double hidden_opacity = 0;
    double lift =
        0;  ///< brings the line nearer by this part of its nearness, above the surface it lies on
};

/// An image of kSamples x kSamples samples a pixel with a depth buffer.
class Canvas {
  public:
    static constexpr int kSamples = 3;

    Canvas(int width, int height);

    /// Fills a triangle, colours blended between its corners.
    void triangle(const std::array<ScreenPoint, 3>& p, const std::array<Light, 3>& colours);
    /// A line of `width` pixels with round ends, opaque to `opacity` where nothing is nearer than
    /// it, to `hidden_opacity` elsewhere; lines that cross do not darken each other.
    void line(const ScreenPoint& a, const ScreenPoint& b, double width, const Pen& pen);

    /// The samples averaged in linear light; 3 channels: on white; 4: with alpha.
    [[nodiscard]] Image image(int channels) const;

  private:
    struct Sample {
        float nearness = -1e30F;  ///< of the surface
        float opacity = 0;        ///< of the line over it
        Srgb colour = {255, 255, 255};
        Srgb ink = {};
        bool covered = false;
    };

    [[nodiscard]] Sample& sample(int x, int y) {
        return samples_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                        static_cast<std::size_t>(x)];
    }
    [[nodiscard]] const Sample& sample(int x, int y) const {
        return const_cast<Canvas*>(this)->sample(x, y);
    }

    int width_;  ///< in samples
    int height_;
    std::vector<Sample> samples_;
};

}  // namespace relief::io::detail
