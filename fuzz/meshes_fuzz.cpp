#include "meshes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    relief::codec::fuzz::meshes({data, size});
    return 0;
}
