#pragma once

#include <gtest/gtest.h>

#include <utility>

#include "relief/edit/session.h"

/// What tests of sessions of all kinds share.
namespace relief::edit {

inline Session opened(Bytes bytes) {
    auto session = Session::open(std::make_shared<MemorySource>(std::move(bytes)));
    EXPECT_TRUE(session.ok()) << session.error().text();
    return *std::move(session);
}

inline SurfaceGeometry surface(const Session& session) {
    auto result = session.surface();
    EXPECT_TRUE(result.ok()) << result.error().text();
    return *std::move(result);
}

}  // namespace relief::edit
