#include "edit/model.h"

namespace relief::edit {
Result<std::unique_ptr<Model>> open_mesh(std::shared_ptr<const ByteSource>) {
    return Error{ErrorCode::Unsupported, "meshes can not be edited yet", ""};
}
}  // namespace relief::edit
