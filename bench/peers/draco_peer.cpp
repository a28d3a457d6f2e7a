#include "draco_peer.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/core/draco_version.h>

#include <array>
#include <memory>
#include <utility>

namespace relief::peers {

namespace {

using draco::AttributeValueIndex;
using draco::DataType;
using draco::GeometryAttribute;
using draco::PointIndex;

Error refused(const draco::Status& status) {
    return {ErrorCode::BadInput, status.error_msg_string(), "Draco"};
}

int add_attribute(draco::Mesh& mesh, GeometryAttribute::Type kind, std::int8_t components,
                  DataType type) {
    GeometryAttribute attribute;
    const auto stride = components * draco::DataTypeLength(type);
    attribute.Init(kind, nullptr, components, type, false, stride, 0);
    return mesh.AddAttribute(attribute, true, mesh.num_points());
}

std::unique_ptr<draco::Mesh> triangles_of(const PolygonMesh& mesh) {
    auto made = std::make_unique<draco::Mesh>();
    draco::Mesh& result = *made;
    result.set_num_points(static_cast<std::uint32_t>(mesh.vertices.size()));
    const int places = add_attribute(result, GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    for (std::uint32_t v = 0; v < result.num_points(); ++v) {
        std::array<float, 3> place{};
        for (std::size_t k = 0; k < 3; ++k) place[k] = static_cast<float>(mesh.vertices[v][k]);
        result.attribute(places)->SetAttributeValue(AttributeValueIndex(v), place.data());
    }
    const auto corner = [](std::int32_t v) { return PointIndex(static_cast<std::uint32_t>(v)); };
    for (std::int64_t f = 0; f < mesh.polygon_count(); ++f) {
        const auto polygon = mesh.polygon(f);
        for (std::size_t k = 2; k < polygon.size(); ++k)
            result.AddFace({corner(polygon[0]), corner(polygon[k - 1]), corner(polygon[k])});
    }
    return made;
}

/// Of a mesh that has its places first.
Result<draco::EncoderBuffer> encode(const draco::Mesh& mesh, const DracoOptions& options) {
    draco::ExpertEncoder encoder(mesh);
    encoder.SetSpeedOptions(options.speed, options.speed);
    encoder.SetAttributeQuantization(0, options.bits);
    draco::EncoderBuffer buffer;
    if (const draco::Status status = encoder.EncodeToBuffer(&buffer); !status.ok())
        return refused(status);
    return buffer;
}

}  // namespace

Result<Bytes> draco_encode(const PolygonMesh& mesh, const DracoOptions& options) {
    RELIEF_TRY(const draco::EncoderBuffer buffer, encode(*triangles_of(mesh), options));
    return Bytes(buffer.data(), buffer.data() + buffer.size());
}

Result<PolygonMesh> draco_decoded(const PolygonMesh& mesh, const DracoOptions& options) {
    const auto made = triangles_of(mesh);
    draco::Mesh& numbered = *made;
    const int numbers = add_attribute(numbered, GeometryAttribute::GENERIC, 1, draco::DT_UINT32);
    for (std::uint32_t v = 0; v < numbered.num_points(); ++v)
        numbered.attribute(numbers)->SetAttributeValue(AttributeValueIndex(v), &v);
    RELIEF_TRY(const draco::EncoderBuffer coded, encode(numbered, options));
    draco::DecoderBuffer buffer;
    buffer.Init(coded.data(), coded.size());
    auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) return refused(decoded.status());
    const draco::Mesh& found = *decoded.value();
    const auto* places = found.GetNamedAttribute(GeometryAttribute::POSITION);
    const auto* own = found.GetNamedAttribute(GeometryAttribute::GENERIC);
    if (places == nullptr || own == nullptr)
        return Error{ErrorCode::BadInput, "lost an attribute", "Draco"};
    PolygonMesh result;
    result.offsets = mesh.offsets;
    result.corners = mesh.corners;
    result.vertices.resize(mesh.vertices.size());
    for (std::uint32_t p = 0; p < found.num_points(); ++p) {
        std::uint32_t v = 0;
        std::array<float, 3> place{};
        own->GetMappedValue(PointIndex(p), &v);
        places->GetMappedValue(PointIndex(p), place.data());
        result.vertices.at(v) = {place[0], place[1], place[2]};
    }
    return result;
}

const char* draco_version() {
    return draco::kDracoVersion;
}

}  // namespace relief::peers
