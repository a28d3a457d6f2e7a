#include "ps.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    relief::codec::fuzz::ps_files({data, size});
    return 0;
}
