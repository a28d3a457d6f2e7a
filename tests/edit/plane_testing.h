#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <vector>

#include "edit/session_testing.h"

/// What tests of sessions with surfaces of quads and triangles share.
namespace relief::edit::test {

inline NetGeometry net(const Session& session, int level) {
    auto result = session.net(level, {});
    EXPECT_TRUE(result.ok()) << result.error().text();
    return *std::move(result);
}

/// A surface as a page holds it: drawn once, then patched.
struct Page {
    SurfaceGeometry shown;

    explicit Page(const Session& session) : shown(surface(session)) {}

    void take(const SurfacePatch& patch) {
        const auto put = [&](auto& all, const auto& some) {
            ASSERT_EQ(some.size(), all.empty() ? 0 : patch.at.size());
            for (std::size_t k = 0; k < some.size(); ++k) all[patch.at[k]] = some[k];
        };
        put(shown.position, patch.position);
        put(shown.normal, patch.normal);
        put(shown.error, patch.error);
        put(shown.curvature, patch.curvature);
    }

    /// Whether a surface drawn anew is the same to the bit.
    void expect_current(const Session& session) const {
        const SurfaceGeometry now = surface(session);
        EXPECT_TRUE(now.position == shown.position);
        EXPECT_TRUE(now.normal == shown.normal);
        EXPECT_TRUE(now.error == shown.error);
        EXPECT_TRUE(now.curvature == shown.curvature);
    }

    /// How many points are drawn otherwise.
    [[nodiscard]] std::size_t differing(const SurfaceGeometry& from) const {
        std::size_t count = 0;
        for (std::size_t k = 0; k < shown.position.size(); ++k)
            count += shown.position[k] != from.position[k] || shown.normal[k] != from.normal[k];
        return count;
    }
};

/// Applies one kind of change after another, with moves of several levels, and calls check() after
/// each; at the end everything is undone.
template <class Check>
void run_history(Session& session, std::uint64_t fine, std::uint64_t coarse, Check&& check) {
    const int last = static_cast<int>(session.description().levels.size()) - 1;
    const auto step = [&](Result<Change> change) {
        ASSERT_TRUE(change.ok()) << change.error().text();
        EXPECT_GT(change->touched, 0U);
        check(*change);
    };
    step(session.apply({.level = last, .points = {coarse}, .delta = {0, 0, 7}}));
    step(session.drag({.level = 0, .points = {fine}, .delta = {0, 0, 2}}));
    step(session.drag({.level = 0, .points = {fine}, .delta = {0, 0, -3.1}}));
    step(session.release());
    step(session.apply({.level = 0,
                        .points = {fine, fine + 1},
                        .delta = {0, 0, 1.3},
                        .falloff = {.radius = 1.7}}));
    step(session.apply({.level = last, .points = {coarse, 0}, .delta = {0, 0, -0.7}}));
    step(session.undo());
    step(session.redo());
    step(session.undo(3));
}

/// All edges of triangles have two of them, or one on the border of the domain; no triangle of the
/// plane lies on its back.
inline void expect_sound(const SurfaceGeometry& surface) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> directed;
    for (std::size_t t = 0; t < surface.index.size(); t += 3) {
        const auto corner = [&](std::size_t k) { return surface.index[t + k % 3]; };
        const auto& a = surface.position[corner(0)];
        const auto& b = surface.position[corner(1)];
        const auto& c = surface.position[corner(2)];
        EXPECT_GT((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]), 0.0F);
        for (std::size_t k = 0; k < 3; ++k) directed.emplace_back(corner(k), corner(k + 1));
    }
    std::sort(directed.begin(), directed.end());
    EXPECT_EQ(std::adjacent_find(directed.begin(), directed.end()), directed.end());
}

/// Heights and normals are those that are told of places, floats below 4 and slopes below 3.
inline void expect_as_told(const Session& session, const SurfaceGeometry& drawn) {
    const double origin = session.description().origin.z;
    for (std::size_t k = 0; k < drawn.position.size(); ++k) {
        const auto probe = *session.at({drawn.position[k][0], drawn.position[k][1]});
        if (!probe) continue;  // floats of the border lie beside it
        const double size = std::sqrt(1 + dot(probe->gradient, probe->gradient));
        ASSERT_NEAR(drawn.position[k][2] + origin, probe->value, 2e-6);
        ASSERT_NEAR(drawn.normal[k][0] / 32767.0, -probe->gradient.x / size, 4e-5);  // 15 bits
        ASSERT_NEAR(drawn.normal[k][1] / 32767.0, -probe->gradient.y / size, 4e-5);
    }
}

/// The errors of a coarse level, nothing being edited: it differs from the finest by what that
/// adds.
inline void expect_errors_of_coarse_level(Session& session, int level) {
    ASSERT_TRUE(session.set_view({.level = level, .extras = {.error = true}}).ok());
    const SurfaceGeometry coarse = surface(session);
    ASSERT_TRUE(session.set_view({.extras = {.error = true}}).ok());
    const double origin = session.description().origin.z;
    for (std::size_t k = 0; k < coarse.position.size(); k += 5) {
        const auto probe = *session.at({coarse.position[k][0], coarse.position[k][1]});
        if (!probe) continue;
        EXPECT_NEAR(coarse.error[k], coarse.position[k][2] + origin - probe->value, 4e-6);
    }
}

/// Draws the compression, of a surface that was encoded with this bound: the first `count` points
/// are off what was shown before, and by no more than the bound.
inline void expect_compressed(Session& session, std::size_t count, double bound) {
    const SurfaceGeometry before = surface(session);
    const auto report = session.compress(bound, {});
    ASSERT_TRUE(report.ok()) << report.error().text();
    EXPECT_LE(report->max_error, bound);
    EXPECT_LT(report->bytes, session.description().bytes);
    ASSERT_TRUE(session.set_view({.show = View::Show::Compressed}).ok());
    const SurfaceGeometry after = surface(session);
    double most = 0;
    for (std::size_t k = 0; k < count; ++k)
        most = std::max<double>(most, std::abs(after.position[k][2] - before.position[k][2]));
    EXPECT_GT(most, 0.0);
    EXPECT_LE(most, bound + 2e-6);  // floats below 16
}

/// Runs commands on a session, and the script of them on another one of the same file: both files
/// are the same.
inline void expect_replayed(Session& session, Session& again,
                            std::initializer_list<const char*> commands) {
    for (const char* command : commands)
        ASSERT_TRUE(session.run(nlohmann::json::parse(command)).ok()) << command;
    ASSERT_TRUE(again.replay(nlohmann::json::parse(session.script().dump())).ok());
    EXPECT_EQ(*again.file(), *session.file());
}

inline void expect_refused(Session& session, const char* command, const char* reason) {
    const auto change = session.run(nlohmann::json::parse(command));
    ASSERT_FALSE(change.ok()) << command;
    EXPECT_NE(change.error().message.find(reason), std::string::npos) << change.error().message;
}

}  // namespace relief::edit::test
