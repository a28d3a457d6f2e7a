#include "quads.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    relief::codec::fuzz::quad_chunks({data, size});
    return 0;
}
