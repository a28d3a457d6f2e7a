#include "shards.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    relief::codec::fuzz::shards({data, size});
    return 0;
}
