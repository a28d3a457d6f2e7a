#include "point_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    relief::io::fuzz::points({data, size});
    return 0;
}
