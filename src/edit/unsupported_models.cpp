#include "edit/model.h"

namespace relief::edit {
Result<std::unique_ptr<Model>> open_mesh(std::shared_ptr<const ByteSource>) {
    return Error{ErrorCode::Unsupported, "meshes can not be edited yet", ""};
}
Result<std::unique_ptr<Model>> open_quads(std::shared_ptr<const ByteSource>) {
    return Error{ErrorCode::Unsupported, "quads can not be edited yet", ""};
}
Result<std::unique_ptr<Model>> open_triangles(std::shared_ptr<const ByteSource>) {
    return Error{ErrorCode::Unsupported, "splines on triangles can not be edited yet", ""};
}
}  // namespace relief::edit
