# What `cmake --install` writes beside what programs and plugins say of themselves: the library with its headers, the
# CMake package `relief`, relief.pc; and the Debian package of all.
include(CMakePackageConfigHelpers)

get_property(modules GLOBAL PROPERTY RELIEF_MODULES)
list(TRANSFORM modules PREPEND relief_ OUTPUT_VARIABLE libraries)

# All modules at once. (The target `relief` is the program.)
add_library(relief_library INTERFACE)
add_library(relief::relief ALIAS relief_library)
target_link_libraries(relief_library INTERFACE ${libraries})
set_target_properties(relief_library PROPERTIES EXPORT_NAME relief)
set_target_properties(relief_options PROPERTIES EXPORT_NAME options)

install(TARGETS ${libraries} relief_library relief_options EXPORT relief
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
foreach(module IN LISTS modules)
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/relief/${module}
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/relief FILES_MATCHING PATTERN *.h)
endforeach()

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/relief)
install(EXPORT relief FILE reliefTargets.cmake NAMESPACE relief:: DESTINATION ${package})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/reliefConfig.cmake.in ${PROJECT_BINARY_DIR}/reliefConfig.cmake
    INSTALL_DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/reliefConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/reliefConfig.cmake ${PROJECT_BINARY_DIR}/reliefConfigVersion.cmake
    DESTINATION ${package})

# relief.pc: a static library needs at link time what it is made with, a shared one brings it.
set(needs libhwy libxxhash libzstd)
if(TBB_FOUND)
    list(APPEND needs tbb)
endif()
if(RELIEF_WITH_IO)
    list(APPEND needs gdal libpng fmt)
endif()
list(JOIN needs ", " needs)
set(RELIEF_PC_REQUIRES "")
if(NOT BUILD_SHARED_LIBS)
    set(RELIEF_PC_REQUIRES ${needs})
endif()
list(REVERSE libraries)
list(TRANSFORM libraries PREPEND -l)
list(JOIN libraries " " RELIEF_PC_LIBS)
# Relative to where relief.pc lies, so that a tree may be moved.
file(RELATIVE_PATH RELIEF_PC_PREFIX ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(${CMAKE_CURRENT_LIST_DIR}/relief.pc.in ${PROJECT_BINARY_DIR}/relief.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/relief.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${PROJECT_SOURCE_DIR}/LICENSE
    DESTINATION ${CMAKE_INSTALL_DOCDIR})
if(TARGET relief)
    if(BUILD_SHARED_LIBS)
        file(RELATIVE_PATH from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
        set_target_properties(relief PROPERTIES INSTALL_RPATH "$ORIGIN/${from_bin}")
    endif()
    install(TARGETS relief RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME relief)
set(CPACK_PACKAGE_CONTACT "The developers of relief")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Multiresolution spline surfaces of terrain, meshes and points")
set(CPACK_PACKAGE_DESCRIPTION "Turns terrain rasters, triangle and quad meshes and scattered points into
multiresolution splines and back, compresses them with verified error bounds,
evaluates them smoothly anywhere, and edits them at any level: program, editor
in the browser, and C++ library.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
include(CPack)
