#include "mesh_readers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    relief::io::fuzz::stl({data, size});
    return 0;
}
