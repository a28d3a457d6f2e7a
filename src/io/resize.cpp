#include <algorithm>
#include <cmath>

#include "io/colour.h"
#include "relief/core/parallel.h"
#include "relief/io/picture.h"

namespace relief::io {

namespace {

/// Cubic filter of Mitchell and Netravali (1988), B = C = 1/3: neither blurred nor ringing.
double mitchell(double t) {
    t = std::abs(t);
    if (t < 1) return ((7 * t - 12) * t * t + 16.0 / 3) / 6;
    if (t < 2) return (((-7.0 / 3 * t + 12) * t - 20) * t + 32.0 / 3) / 6;
    return 0;
}

/// Which input samples make an output sample, and their weights, which sum to 1.
struct Taps {
    int first = 0;
    std::vector<float> weights;
};

std::vector<Taps> filter(int from, int to) {
    const double ratio = static_cast<double>(from) / to;
    const double stretch = std::max(1.0, ratio);
    std::vector<Taps> all(static_cast<std::size_t>(to));
    for (int k = 0; k < to; ++k) {
        const double centre = (k + 0.5) * ratio - 0.5;
        Taps& taps = all[static_cast<std::size_t>(k)];
        taps.first = std::max(0, static_cast<int>(std::ceil(centre - 2 * stretch)));
        const int last = std::min(from - 1, static_cast<int>(std::floor(centre + 2 * stretch)));
        double sum = 0;
        for (int i = taps.first; i <= last; ++i) sum += mitchell((i - centre) / stretch);
        for (int i = taps.first; i <= last; ++i)
            taps.weights.push_back(static_cast<float>(mitchell((i - centre) / stretch) / sum));
    }
    return all;
}

/// One image row in linear light, colours multiplied by alpha.
void load_row(const Image& image, int row, float* out) {
    for (int c = 0; c < image.width; ++c, out += 4) {
        const std::uint8_t* p = image.pixel(row, c);
        const double alpha = image.channels == 4 ? p[3] / 255.0 : 1.0;
        for (int k = 0; k < 3; ++k) out[k] = static_cast<float>(detail::linear_of(p[k]) * alpha);
        out[3] = static_cast<float>(alpha);
    }
}

void store_pixel(const float* in, int channels, std::uint8_t* p) {
    const double alpha = std::clamp(static_cast<double>(in[3]), 0.0, 1.0);
    for (int k = 0; k < 3; ++k)
        p[k] = detail::code_of(alpha > 0 ? static_cast<double>(in[k]) / alpha : 0);
    if (channels == 4) p[3] = static_cast<std::uint8_t>(std::lround(255 * alpha));
}

}  // namespace

Image resize(const Image& image, int width, int height) {
    Image out(width, height, image.channels);
    const std::vector<Taps> across = filter(image.width, width);
    const std::vector<Taps> down = filter(image.height, height);
    const std::int64_t stride = std::int64_t{4} * width;
    Grid<float> narrow(image.height, stride);  // resized along the rows only
    parallel_for(0, image.height, 16, [&](std::int64_t first, std::int64_t last) {
        std::vector<float> row(4 * static_cast<std::size_t>(image.width));
        for (std::int64_t r = first; r < last; ++r) {
            load_row(image, static_cast<int>(r), row.data());
            for (std::int64_t k = 0; k < stride; ++k) {
                const Taps& taps = across[static_cast<std::size_t>(k / 4)];
                const float* in = row.data() + 4 * taps.first + k % 4;
                float sum = 0;
                for (std::size_t i = 0; i < taps.weights.size(); ++i)
                    sum += taps.weights[i] * in[4 * i];
                narrow(r, k) = sum;
            }
        }
    });
    parallel_for(0, height, 16, [&](std::int64_t first, std::int64_t last) {
        std::vector<float> row(static_cast<std::size_t>(stride));
        for (std::int64_t r = first; r < last; ++r) {
            const Taps& taps = down[static_cast<std::size_t>(r)];
            std::fill(row.begin(), row.end(), 0.0F);
            for (std::size_t i = 0; i < taps.weights.size(); ++i) {
                const float* in = narrow.row(taps.first + static_cast<std::int64_t>(i));
                for (std::size_t k = 0; k < row.size(); ++k) row[k] += taps.weights[i] * in[k];
            }
            for (int c = 0; c < width; ++c)
                store_pixel(row.data() + 4 * c, image.channels, out.pixel(static_cast<int>(r), c));
        }
    });
    return out;
}

}  // namespace relief::io
