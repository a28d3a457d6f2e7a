# relief_module(NAME [DEPENDS module...]): the library relief_NAME, alias relief::NAME, of src/NAME/*.cpp; installed.
# DEPENDS names modules of lower floors only; tools/check_includes verifies that includes follow.

add_library(relief_options INTERFACE)
target_compile_features(relief_options INTERFACE cxx_std_20)
# A decoder repeats the encoder's arithmetic to the bit: the compiler must not fuse multiplications and additions.
target_compile_options(relief_options INTERFACE -ffp-contract=off)

add_library(relief_warnings INTERFACE)
target_compile_options(relief_warnings INTERFACE -Wall -Wextra -Wshadow -Wpedantic -Wnon-virtual-dtor)
# GCC 12 sees overlapping copies in std::string concatenation where there are none (GCC bug 105651).
target_compile_options(relief_warnings INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
if(RELIEF_WERROR)
    target_compile_options(relief_warnings INTERFACE -Werror)
endif()

function(relief_module name)
    cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
    file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
    add_library(relief_${name} ${sources})
    add_library(relief::${name} ALIAS relief_${name})
    target_include_directories(relief_${name}
        PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
        PRIVATE ${PROJECT_SOURCE_DIR}/src)
    target_link_libraries(relief_${name} PUBLIC relief_options PRIVATE $<BUILD_INTERFACE:relief_warnings>)
    # Before 1.0 a minor version may change the binary interface.
    set_target_properties(relief_${name} PROPERTIES EXPORT_NAME ${name} DEFINE_SYMBOL ""
        VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
    set_property(GLOBAL APPEND PROPERTY RELIEF_MODULES ${name})
    foreach(module IN LISTS ARG_DEPENDS)
        target_link_libraries(relief_${name} PUBLIC relief_${module})
    endforeach()
endfunction()
