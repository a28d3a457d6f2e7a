#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "relief/io/mesh.h"

namespace relief::io {

using Vertices = std::vector<std::array<double, 3>>;
using Indices = std::vector<std::int32_t>;
using Values = std::vector<double>;

inline std::span<const std::uint8_t> bytes_of(const std::string& text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The value, or a failure with the text of the error and an empty value.
template <class T>
T value_of(const Result<T>& result) {
    EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().text());
    return result.ok() ? *result : T();
}

inline PolygonMesh off(const std::string& text) {
    return value_of(parse_off(bytes_of(text), "a.off"));
}
inline PolygonMesh obj(const std::string& text) {
    return value_of(parse_obj(bytes_of(text), "a.obj"));
}
inline PolygonMesh ply(const std::string& text) {
    return value_of(parse_ply(bytes_of(text), "a.ply"));
}
inline LoadedMesh stl(const std::string& text) {
    return value_of(parse_stl(bytes_of(text), "a.stl"));
}

/// An error in `where`, whose message has `says` in it.
template <class T>
void expect_refused(const Result<T>& result, const std::string& where, const std::string& says,
                    ErrorCode code = ErrorCode::BadInput) {
    ASSERT_FALSE(result.ok()) << where << ": " << says;
    EXPECT_EQ(result.error().where, where) << result.error().message;
    EXPECT_NE(result.error().message.find(says), std::string::npos) << result.error().message;
    EXPECT_EQ(result.error().code, code) << result.error().message;
}

}  // namespace relief::io
